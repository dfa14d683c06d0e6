// A page's server before browsers that behave, and before others.
#include "view/server.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <string>
#include <vector>

#include "tests/support/view/browser.hpp"
#include "tests/support/view/server_bench.hpp"
#include "view/connection.hpp"

namespace arkmesh::tests {
namespace {

using nlohmann::json;
using view::Connection;

std::string newest(Browser& browser, const std::string& channel, int lab = 0) {
  const auto& messages = browser.messages();
  const auto is_it = [&](const auto& m) { return m.kind() == 1 && m.lab() == lab && m.channel() == channel; };
  const auto found = std::find_if(messages.rbegin(), messages.rend(), is_it);
  return found == messages.rend() ? std::string() : found->data();
}

TEST_CASE("a browser gets types and what the server is, with headers that let nobody else have it") {
  ServerBench bench;
  Browser browser(bench.loop, bench.server.port());
  const std::string about = browser.ask("GET /about.json");
  CHECK(Browser::status(about) == 200);
  CHECK(about.find(R"("labs":["a","b"])") != std::string::npos);
  CHECK(about.find("Content-Security-Policy: default-src 'self'") != std::string::npos);
  CHECK(about.find("no-store") != std::string::npos);
  const std::string types = browser.ask("GET /types.json");  // on the same connection
  CHECK(types.find("pose_frame_t") != std::string::npos);
  CHECK(Browser::status(browser.ask("GET /../etc/passwd")) == 404);
  CHECK(Browser::status(browser.ask("DELETE /about.json")) == 405);
  CHECK(bench.server.url() == "http://127.0.0.1:" + std::to_string(bench.server.port()) + "/");
}

TEST_CASE("every request must name the server, and come from its own page") {
  ServerBench bench;
  const auto ask = [&](const std::map<std::string, std::string>& headers) {
    return Browser::status(Browser(bench.loop, bench.server.port()).ask("GET /about.json", headers));
  };
  const auto join = [&](const std::map<std::string, std::string>& headers) {
    return Browser(bench.loop, bench.server.port()).join(headers);
  };
  const std::string port = std::to_string(bench.server.port());
  CHECK(ask({}) == 200);
  CHECK(ask({{"Host", "localhost:" + port}}) == 200);
  CHECK(ask({{"Host", "evil.example:" + port}}) == 403);  // a name that was made to mean 127.0.0.1
  CHECK(ask({{"Host", ""}}) == 403);
  CHECK(bench.count("refused.host") == 2);
  CHECK(ask({{"Origin", "http://evil.example"}}) == 403);
  CHECK(ask({{"Origin", "http://127.0.0.1:" + port}}) == 200);
  CHECK(join({{"Origin", "http://evil.example"}}) == 403);
  CHECK(join({{"Origin", "null"}}) == 403);
  CHECK(join({}) == 403);  // browsers always say it
  CHECK(bench.count("refused.origin") == 4);
  CHECK(join({{"Origin", "http://127.0.0.1:" + port}, {"Host", "evil.example:" + port}}) == 403);
  CHECK(join({{"Origin", "http://localhost:" + port}}) == 403);
  CHECK(join({{"Origin", "http://localhost:" + port}, {"Host", "localhost:" + port}}) == 101);
  CHECK(bench.counts("viewers"));
}

TEST_CASE("a viewer gets what is there already, then the newest of each channel, and every command") {
  ServerBench bench;
  bench.show("arena", "walls");
  bench.show("poses", "first");
  bench.server.set_camera(0, {{"name", "camera0"}, {"width_px", 2}});
  bench.server.tell(0, 5, "running");
  Browser browser(bench.loop, bench.server.port());
  REQUIRE(browser.join() == 101);
  REQUIRE(browser.hears("hello"));
  CHECK(browser.said("hello")["token_ok"] == false);
  CHECK(browser.said("hello")["mode"] == "live");
  CHECK(comes_to(serving(bench.loop),
                 [&] { return newest(browser, "poses") == "first" && newest(browser, "arena") == "walls"; }));
  CHECK(browser.said("cameras")[0]["name"] == "camera0");
  CHECK(browser.said("events")["lines"][0]["text"] == "running");
  const std::size_t before = browser.messages().size();
  for (int i = 0; i < 1000; ++i) bench.show("poses", std::to_string(i), 1, i);
  for (int i = 0; i < 5; ++i) bench.show("fleet_command", std::to_string(i));
  CHECK(comes_to(serving(bench.loop), [&] { return newest(browser, "poses", 1) == "999"; }));
  std::string commands;
  for (const auto& message : browser.messages())
    if (message.kind() == 1 && message.channel() == "fleet_command") commands += message.data();
  CHECK(commands.starts_with("01234"));
  CHECK(browser.messages().size() < before + 20);
  const auto counted = "/labs/1/channels/poses/count"_json_pointer;
  CHECK(comes_to(serving(bench.loop), [&] {
    const json rates = browser.said("rates");
    return rates.contains(counted) && rates[counted] == 1000;
  }));
}

TEST_CASE("a desk is asked for what comes on no bus while somebody watches, and not otherwise") {
  ServerBench bench;
  Browser asking(bench.loop, bench.server.port());
  CHECK(Browser::status(asking.ask("GET /about.json")) == 200);
  CHECK(bench.desk.refreshed == 0);
  Browser browser(bench.loop, bench.server.port());
  REQUIRE(browser.join() == 101);
  CHECK(comes_to(serving(bench.loop), [&] { return bench.desk.refreshed >= 3; }));
}

TEST_CASE("an answer may come later, and to a viewer that has left it does not matter") {
  struct LaterDesk final : view::Desk {
    json about() override { return {{"labs", json::array()}}; }
    void command(const json&, view::Answer&) override {}
    void request(const json&, view::Answer& answer) override { answers.push_back(answer); }
    std::vector<view::Answer> answers;
  } desk;
  boost::asio::io_context loop;
  view::Server server(loop, {.port = 0}, desk);
  Browser stays(loop, server.port());
  REQUIRE(stays.join() == 101);
  {
    Browser goes(loop, server.port());
    REQUIRE(goes.join() == 101);
    stays.say({{"request", 1}});
    stays.say({{"request", 2}});
    goes.say({{"request", 3}});
    REQUIRE(comes_to(serving(loop), [&] { return desk.answers.size() == 3; }));
  }
  REQUIRE(comes_to(serving(loop), [&] { return server.viewers() == 1; }));
  for (view::Answer& answer : desk.answers) answer.done({{"text", "late"}});
  CHECK(comes_to(serving(loop), [&] { return stays.said("done") == json{{"request", 2}, {"text", "late"}}; }));
  desk.answers.front().refuse("Never mind.");
  CHECK(comes_to(serving(loop), [&] { return stays.said("refused")["request"] == 1; }));
}

TEST_CASE("only who has shown the token may command, by a message or by a cookie") {
  ServerBench bench;
  const json stop = {{"command", {{"name", "stop"}}}, {"request", 3}};
  Browser stranger(bench.loop, bench.server.port());
  REQUIRE(stranger.join() == 101);
  stranger.say(stop);
  REQUIRE(stranger.hears("refused"));
  CHECK(stranger.said("refused")["request"] == 3);
  stranger.say({{"token", std::string(32, '0')}});
  CHECK(bench.counts("refused.token"));
  stranger.say(stop);
  CHECK(bench.counts("refused.no_token", 2));
  CHECK(bench.desk.commands.empty());
  // Each is told, so that somebody writes it down.
  CHECK(bench.desk.refusals == std::vector<json>{{{"what", stop}, {"why", "no_token"}, {"from", "127.0.0.1"}},
                                                 {{"what", nullptr}, {"why", "wrong_token"}, {"from", "127.0.0.1"}},
                                                 {{"what", stop}, {"why", "no_token"}, {"from", "127.0.0.1"}}});
  stranger.say({{"token", bench.token()}});
  stranger.say(stop);
  REQUIRE(stranger.hears("done"));
  CHECK(stranger.said("hello")["token_ok"] == true);
  CHECK(bench.desk.commands.size() == 1);

  Browser page(bench.loop, bench.server.port());
  const std::map<std::string, std::string> own{{"Origin", page.origin()}};
  CHECK(Browser::status(page.ask("POST /token", own, "wrong")) == 403);
  CHECK(Browser::status(Browser(bench.loop, bench.server.port()).ask("POST /token", {}, bench.token())) == 403);
  const std::string set = page.ask("POST /token", own, bench.token());
  CHECK(Browser::status(set) == 204);
  const auto at = set.find("Set-Cookie: ") + 12;
  Browser again(bench.loop, bench.server.port());
  REQUIRE(again.join({{"Origin", again.origin()}, {"Cookie", set.substr(at, set.find(';', at) - at)}}) == 101);
  REQUIRE(again.hears("hello"));
  CHECK(again.said("hello")["token_ok"] == true);
}

TEST_CASE("requests are answered in their order; what fails, or is too much, is refused in a sentence") {
  ServerBench bench;
  Browser browser(bench.loop, bench.server.port());
  REQUIRE(browser.join() == 101);
  browser.say({{"request", 7}, {"count", 3}});
  REQUIRE(browser.hears("done"));
  std::vector<std::int64_t> times;
  for (const auto& message : browser.messages())
    if (message.kind() == 1 && message.request() == 7 && message.lab() == 1) times.push_back(message.t_us());
  CHECK(times == std::vector<std::int64_t>{0, 1, 2});
  browser.say({{"request", 8}, {"fail", true}});
  REQUIRE(browser.hears("refused"));
  CHECK(browser.said("refused") == json{{"request", 8}, {"why", "This cannot be."}});
  browser.say({{"request", 9}, {"count", 40}, {"bytes", 1 << 20}});
  CHECK(comes_to(serving(bench.loop), [&] { return browser.said("refused")["request"] == 9; }));
  browser.say({{"nonsense", 1}});
  CHECK(bench.counts("refused.unknown"));
  CHECK_FALSE(browser.is_gone());
}

TEST_CASE("a viewer that reads nothing holds the newest of each channel and no more, and the others go on") {
  ServerBench bench;
  Browser still(bench.loop, bench.server.port()), quick(bench.loop, bench.server.port());
  REQUIRE(still.join() == 101);
  REQUIRE(quick.join() == 101);
  // Far more than the kernel holds for a connection.
  const std::string large(1 << 20, 'x');
  for (int i = 0; i < 40; ++i) {
    bench.show("poses", large + std::to_string(i));
    bench.server.sample();
    CHECK(comes_to(serving(bench.loop), [&] { return newest(quick, "poses").ends_with("x" + std::to_string(i)); }));
  }
  CHECK(bench.count("replaced") > 20);
  CHECK(bench.server.sending());
  CHECK(comes_to(serving(bench.loop), [&] { return newest(still, "poses").ends_with("x39"); }));
  std::size_t came = 0;
  for (const auto& message : still.messages()) came += message.bytes.size() > large.size();
  CHECK(came < 20);
}

TEST_CASE("garbage, and a gigabyte, end a connection and are counted") {
  ServerBench bench;
  const auto port = bench.server.port();
  const auto is_ended = [&](Browser& browser) {
    return comes_to(serving(bench.loop), [&] { return browser.is_gone(); });
  };
  {
    Browser browser(bench.loop, port);
    browser.send("\x16\x03\x01 this is no HTTP\r\n\r\n");
    CHECK(is_ended(browser));
    CHECK(bench.counts("refused.no_http", 1));
  }
  {
    Browser browser(bench.loop, port);
    CHECK(Browser::status(browser.ask("GET /" + std::string(100'000, 'a'))) == 431);
    CHECK(is_ended(browser));
    CHECK(bench.counts("refused.request_too_long", 1));
  }
  for (const std::string& junk : {std::string("no json"), std::string("[1,2]"), std::string(60'000, '[')}) {
    Browser browser(bench.loop, port);
    REQUIRE(browser.join() == 101);
    browser.send(Browser::framed(junk));
    CHECK(is_ended(browser));
  }
  CHECK(bench.counts("sent_away.garbage", 3));
  for (const std::string& junk :
       {Browser::framed("{}", 2), std::string(20, '\xff'), std::string("\x81\x02{}", 4), Browser::framed("\xff\xfe")}) {
    Browser browser(bench.loop, port);
    REQUIRE(browser.join() == 101);
    browser.send(junk);
    CHECK(is_ended(browser));
  }
  CHECK(bench.counts("sent_away.garbage", 7));
  {
    // A frame that says that it has a gigabyte, and begins to send it.
    Browser browser(bench.loop, port);
    REQUIRE(browser.join() == 101);
    browser.send(std::string("\x81\xff\x00\x00\x00\x00\x40\x00\x00\x00\x00\x00\x00\x00", 14));
    const std::string part(1 << 16, ' ');
    for (int i = 0; i < 16'384 && browser.send(part);) ++i;
    CHECK(is_ended(browser));
    CHECK(bench.counts("sent_away.too_long", 1));
  }
  {
    // The same in small frames of one message.
    Browser browser(bench.loop, port);
    REQUIRE(browser.join() == 101);
    std::string part = Browser::framed(std::string(1000, ' '), 0);
    part[0] = 0;
    std::string first = Browser::framed("{", 1);
    first[0] = 1;
    browser.send(first);
    int sent = 0;
    while (sent < 1000 && browser.send(part)) ++sent;
    CHECK(is_ended(browser));
    CHECK(bench.counts("sent_away.too_long", 2));
  }
  CHECK(comes_to(serving(bench.loop), [&] { return bench.server.viewers() == 0; }));
}

TEST_CASE("a flood of messages is read slowly, and keeps nobody else waiting") {
  ServerBench bench;
  Browser flood(bench.loop, bench.server.port()), other(bench.loop, bench.server.port());
  REQUIRE(flood.join() == 101);
  REQUIRE(other.join() == 101);
  std::string many;
  for (int i = 0; i < 1000; ++i) many += Browser::framed(R"({"request": 1})");
  flood.send(many);
  other.say({{"request", 5}});
  CHECK(other.hears("done"));
  CHECK(bench.counts("late.too_many_messages"));
  Browser pings(bench.loop, bench.server.port());
  REQUIRE(pings.join() == 101);
  std::string ping;
  for (int i = 0; i < 2000; ++i) ping += Browser::framed("", 9);
  pings.send(ping);
  CHECK(comes_to(serving(bench.loop), [&] { return pings.is_gone(); }));
}

TEST_CASE("a viewer that says nothing but answers pings stays, however many there were") {
  ServerBench bench;
  Browser viewer(bench.loop, bench.server.port());
  REQUIRE(viewer.join() == 101);
  std::string pongs;
  for (int i = 0; i < Connection::max_controls_per_s - 1; ++i) pongs += Browser::framed("", 10);
  for (int seconds = 0; seconds < 3; ++seconds) {
    viewer.send(pongs);
    const auto next = std::chrono::steady_clock::now() + std::chrono::milliseconds(1001);
    comes_to(serving(bench.loop), [&] { return viewer.is_gone() || std::chrono::steady_clock::now() > next; });
  }
  CHECK_FALSE(viewer.is_gone());
  viewer.say({{"request", 1}});
  CHECK(viewer.hears("done"));
  CHECK(bench.count("sent_away.garbage") == 0);
}

TEST_CASE("when the port is taken the next one is, and beyond loopback there is nothing without a key") {
  ServerBench first;
  TestDesk desk;
  const std::uint16_t taken = first.server.port();
  view::Server second(first.loop, {.port = taken}, desk);
  CHECK(second.port() > taken);
  CHECK_THROWS_WITH_AS(view::Server(first.loop, {.port = taken, .ports = 1}, desk), doctest::Contains("in use"),
                       std::runtime_error);
  CHECK_THROWS_WITH_AS(view::Server(first.loop, {.address = "0.0.0.0", .port = 0}, desk),
                       doctest::Contains("over TLS only"), std::runtime_error);
}

TEST_CASE("a server that ends says goodbye to nobody and leaves nothing behind") {
  boost::asio::io_context loop;
  TestDesk desk;
  auto server = std::make_unique<view::Server>(loop, view::ServerOptions{.port = 0}, desk);
  Browser watching(loop, server->port()), asking(loop, server->port());
  REQUIRE(watching.join() == 101);
  asking.send("GET /about.json HT");
  loop.poll();
  server.reset();
  CHECK(comes_to(serving(loop), [&] { return watching.is_gone() && asking.is_gone(); }));
  loop.restart();
  loop.poll();
  CHECK(loop.stopped());  // nothing is left to be done
}

}  // namespace
}  // namespace arkmesh::tests
