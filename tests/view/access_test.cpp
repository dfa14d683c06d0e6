// Which requests come from a server's own page, and who may control.
#include "view/access.hpp"

#include <doctest/doctest.h>

#include <string>

namespace arkmesh::tests {
namespace {

const view::Access open_access({"lab.example", "table.example:9000"}, 8800, false);
const view::Access tls_access({}, 443, true);

TEST_CASE("a server is known by the address that was reached, localhost, and the names that it was given") {
  for (const char* host :
       {"127.0.0.1:8800", "localhost:8800", "LOCALHOST:8800", "lab.example:8800", "table.example:9000"})
    CHECK_MESSAGE(open_access.is_host(host, "127.0.0.1"), host);
  CHECK(open_access.is_host("[::1]:8800", "::1"));
  CHECK(tls_access.is_host("192.0.2.7", "192.0.2.7"));
  CHECK(tls_access.is_host("192.0.2.7:443", "192.0.2.7"));
  for (const char* host :
       {"", "127.0.0.1", "127.0.0.1:8801", "127.0.0.2:8800", "evil.example:8800", "localhost.evil.example:8800",
        "[::1]:8800", "lab.example:9000", "table.example:8800", ":8800", "127.0.0.1:8800:8800", "["})
    CHECK_MESSAGE(!open_access.is_host(host, "127.0.0.1"), host);
  CHECK_FALSE(open_access.is_host(std::string(1000, 'a'), "127.0.0.1"));
}

TEST_CASE("an origin is the server's own when scheme, host and port are") {
  CHECK(open_access.is_own_origin("http://127.0.0.1:8800", "127.0.0.1:8800"));
  CHECK(tls_access.is_own_origin("https://192.0.2.7", "192.0.2.7"));
  for (const char* origin :
       {"", "null", "https://127.0.0.1:8800", "http://127.0.0.1", "http://127.0.0.1:9999", "http://localhost:8800",
        "http://evil.example", "http://127.0.0.1:8800.evil.example", "file://"})
    CHECK_MESSAGE(!open_access.is_own_origin(origin, "127.0.0.1:8800"), origin);
}

TEST_CASE("token and cookie are two secrets of one server alone") {
  CHECK(open_access.token().size() == 32);
  CHECK(open_access.token() != tls_access.token());
  CHECK(open_access.is_token(open_access.token()));
  CHECK_FALSE(open_access.is_token(tls_access.token()));
  CHECK_FALSE(open_access.is_token(""));
  CHECK_FALSE(open_access.is_token(open_access.token().substr(1)));
  const std::string set = open_access.set_cookie(), cookie = set.substr(0, set.find(';'));
  CHECK(set.find("SameSite=Strict") != std::string::npos);
  CHECK(set.find("HttpOnly") != std::string::npos);
  CHECK(set.find("Secure") == std::string::npos);
  CHECK(tls_access.set_cookie().find("Secure") != std::string::npos);
  CHECK(cookie.find(open_access.token()) == std::string::npos);
  CHECK(open_access.has_cookie(cookie));
  CHECK(open_access.has_cookie("other=1; " + cookie + "; more=2"));
  CHECK_FALSE(open_access.has_cookie("x" + cookie));
  CHECK_FALSE(open_access.has_cookie(cookie + "0"));
  CHECK_FALSE(open_access.has_cookie(""));
  CHECK_FALSE(open_access.has_cookie("arkmesh_view_8800=" + open_access.token()));
}

}  // namespace
}  // namespace arkmesh::tests
