// Addresses of NATS servers.
#include "gateway/federation/nats_address.hpp"

#include <doctest/doctest.h>

namespace arkmesh::gateway {

TEST_CASE("passwords of servers are not for logs") {
  CHECK(without_passwords("tls+nats://shark:se:cr@t@a.example.org:4222,roark:other@b.example.org") ==
        "tls+nats://a.example.org:4222,b.example.org");
  CHECK(without_passwords("nats://a.example.org, nats://u:p@127.0.0.1:4222") ==
        "nats://a.example.org, nats://127.0.0.1:4222");
  CHECK(without_passwords("tls://shark.example.org:7444") == "tls://shark.example.org:7444");
  CHECK(without_passwords("") == "");
}

}  // namespace arkmesh::gateway
