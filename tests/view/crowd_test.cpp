// A page's server before many: who gets in, who makes way, and who waits.
#include <doctest/doctest.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/view/browser.hpp"
#include "tests/support/view/server_bench.hpp"

namespace arkmesh::tests {
namespace {

using nlohmann::json;

TEST_CASE("who guesses tokens waits longer each time and is sent away; who has the right one does not wait") {
  ServerBench bench;
  Browser guesser(bench.loop, bench.server.port()), other(bench.loop, bench.server.port());
  REQUIRE(guesser.join() == 101);
  for (int i = 0; i < 5; ++i) guesser.say({{"token", i}});
  const auto begun = std::chrono::steady_clock::now();
  CHECK(comes_to(serving(bench.loop), [&] { return guesser.is_gone(); }));
  // 50, 100, 200 and 400 ms; the fifth ends it.
  CHECK(std::chrono::steady_clock::now() - begun >= std::chrono::milliseconds(750));
  CHECK(bench.count("refused.token") == 5);
  // The next wrong one of that address is answered after 1.6 s.
  const std::map<std::string, std::string> own{{"Origin", other.origin()}};
  Browser wrong(bench.loop, bench.server.port());
  const std::string body = "guess";
  wrong.send("POST /token HTTP/1.1\r\nHost: " + wrong.host() + "\r\nOrigin: " + wrong.origin() +
             "\r\nContent-Length: 5\r\n\r\n" + body);
  REQUIRE(bench.counts("refused.token", 6));
  const auto asked = std::chrono::steady_clock::now();
  CHECK(Browser::status(other.ask("POST /token", own, bench.token())) == 204);
  // a machine that was away for so long has both to answer
  CHECK((!wrong.has_answer() || std::chrono::steady_clock::now() - asked >= std::chrono::milliseconds(1500)));
  CHECK(Browser::status(wrong.heard_next()) == 403);
  CHECK(std::chrono::steady_clock::now() - asked >= std::chrono::milliseconds(1500));
}

// The cookie that a page gets for the token.
std::string cookie_of(boost::asio::io_context& loop, const view::Server& server) {
  const std::string url = server.url_with_token();
  Browser page(loop, server.port());
  const std::string set =
      page.ask("POST /token", {{"Origin", page.origin()}}, std::string_view(url).substr(url.find("#token=") + 7));
  const auto at = set.find("Set-Cookie: ");
  return at == std::string::npos ? std::string() : set.substr(at + 12, set.find(';', at) - at - 12);
}

TEST_CASE("so many may watch as was said; who has the token gets the place of the newest who has not") {
  boost::asio::io_context loop;
  TestDesk desk;
  view::Server server(loop, {.port = 0, .max_viewers = 2}, desk);
  Browser a(loop, server.port()), b(loop, server.port()), c(loop, server.port());
  CHECK(a.join() == 101);
  CHECK(b.join() == 101);
  CHECK(c.join() == 503);
  CHECK(server.counters()["view.refused.too_many_viewers"] == 1);
  const std::string cookie = cookie_of(loop, server);
  REQUIRE_FALSE(cookie.empty());
  Browser first(loop, server.port()), second(loop, server.port()), third(loop, server.port());
  const std::map<std::string, std::string> shown{{"Origin", a.origin()}, {"Cookie", cookie}};
  CHECK(first.join(shown) == 101);
  CHECK(comes_to(serving(loop), [&] { return b.is_gone(); }));
  CHECK_FALSE(a.is_gone());
  CHECK(second.join(shown) == 101);
  CHECK(comes_to(serving(loop), [&] { return a.is_gone(); }));
  CHECK(server.counters()["view.sent_away.made_way"] == 2);
  // Now all have it: nobody makes way.
  CHECK(third.join(shown) == 503);
  CHECK_FALSE(first.is_gone());
  CHECK(server.viewers() == 2);
}

TEST_CASE("however many connections strangers hold, the operator's page opens and commands") {
  boost::asio::io_context loop;
  TestDesk desk;
  view::Server server(loop, {.port = 0, .max_viewers = 2}, desk);
  std::vector<std::unique_ptr<Browser>> strangers;
  const auto one_more = [&] {
    strangers.push_back(std::make_unique<Browser>(loop, server.port()));
    serving(loop)();
  };
  for (int i = 0; i < 2; ++i) {
    one_more();
    CHECK(strangers.back()->join() == 101);
  }
  for (int i = 0; i < 60; ++i) one_more();
  CHECK(server.counters()["view.sent_away.made_way"] == 60 + 2 - 34);
  CHECK_FALSE(strangers.front()->is_gone());  // those that watch stay
  Browser page(loop, server.port());
  CHECK(Browser::status(page.ask("GET /")) == 200);
  const std::string cookie = cookie_of(loop, server);
  const std::map<std::string, std::string> shown{{"Origin", page.origin()}, {"Cookie", cookie}};
  CHECK(Browser::status(page.ask("GET /about.json", shown)) == 200);
  // From now on this connection is the operator's, and stays whoever comes.
  for (int i = 0; i < 60; ++i) one_more();
  CHECK_FALSE(page.is_gone());
  Browser operators(loop, server.port());
  REQUIRE(operators.join(shown) == 101);
  operators.say({{"command", {{"name", "stop"}}}});
  CHECK(operators.hears("done"));
  CHECK(desk.commands.size() == 1);
}

TEST_CASE("as long as all who are there have the token, nobody makes way for one more connection") {
  boost::asio::io_context loop;
  TestDesk desk;
  view::Server server(loop, {.port = 0, .max_viewers = 1}, desk);
  const std::string cookie = cookie_of(loop, server);
  std::vector<std::unique_ptr<Browser>> pages;
  for (int i = 0; i < 33; ++i) {
    pages.push_back(std::make_unique<Browser>(loop, server.port()));
    CHECK(Browser::status(pages.back()->ask("GET /about.json", {{"Cookie", cookie}})) == 200);
  }
  Browser late(loop, server.port());
  CHECK(comes_to(serving(loop), [&] { return late.is_gone(); }));
  CHECK(server.counters()["view.refused.too_many_connections"] == 1);
}

}  // namespace
}  // namespace arkmesh::tests
