// The page of labs that run: what it costs their results, and what who has its token may do.
#include <doctest/doctest.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/live/view_identity.hpp"
#include "arkmesh/lab_status_t.hpp"
#include "hal/bus/bus.hpp"
#include "hal/config/config.hpp"
#include "tests/support/labs/dhtf_labs.hpp"
#include "tests/support/labs/lab_processes.hpp"
#include "tests/support/network/test_keys.hpp"
#include "tests/support/view/browser.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using nlohmann::json;
using tests::Browser;

namespace {

std::uint16_t port_in(const std::string& url) {
  return static_cast<std::uint16_t>(std::stoi(url.substr(url.find(':', 6) + 1)));
}
std::string token_in(const std::string& url) {
  return url.substr(url.find("#token=") + 7, 32);
}

// The URL that a lab's process has printed; empty when it has printed none.
std::string printed_url(const std::string& output) {
  const auto at = output.find("http://127.0.0.1:");
  return at == std::string::npos ? std::string() : output.substr(at, output.find('\n', at) - at);
}

// The kernel and the lab's process do what there is to do meanwhile.
const tests::Serve elsewhere = [] { ::poll(nullptr, 0, 2); };

std::vector<std::string> channels_of(Browser& browser) {
  std::vector<std::string> out;
  for (const auto& message : browser.messages())
    if (message.kind() == 1) out.push_back(message.channel());
  return out;
}

bool hears_channel(Browser& browser, const std::string& channel) {
  return tests::comes_to(elsewhere, [&] {
    const auto all = channels_of(browser);
    return std::find(all.begin(), all.end(), channel) != all.end();
  });
}

}  // namespace

TEST_CASE("labs come to the same hash with viewers, one of whom reads nothing, and without") {
  const auto run_with = [](bool page) {
    const tests::TemporaryFolder folder;
    app::JointRun run(tests::dhtf_configs({}), folder.path(), app::JointRun::Folder::must_be_empty, {}, page);
    REQUIRE((run.page() != nullptr) == page);
    std::vector<std::unique_ptr<Browser>> browsers;
    bool going = true;
    const tests::Serve serve = [&] { going = run.step() && going; };
    if (page)
      for (int i = 0; i < 4; ++i) {
        browsers.push_back(std::make_unique<Browser>(serve, port_in(run.page()->url())));
        CHECK(browsers.back()->join() == 101);
      }
    std::size_t heard = 0;
    for (std::uint64_t step = 0;; ++step) {
      serve();
      if (!going) break;
      if (step % 64 == 0)
        for (std::size_t i = 1; i < browsers.size(); ++i) heard = browsers[i]->messages().size();
    }
    REQUIRE(run.finished());
    if (page) {
      CHECK(heard > 20);
      CHECK(run.lab(0).runner().drops()["view.viewers"] == 4);
    }
    return run.lab(0).runner().final_hash();
  };
  CHECK(run_with(true) == run_with(false));
}

TEST_CASE("viewers of labs whose clock counts steps have their status as it is now, and the bus has no more of it") {
  const tests::TemporaryFolder folder;
  app::JointRun run(tests::dhtf_configs({}), folder.path(), app::JointRun::Folder::must_be_empty, {}, true);
  int on_bus = 0;
  const auto heard = run.lab(0).bus().subscribe("status", [&](auto, auto) { ++on_bus; });
  const tests::Serve slow_steps = [&] {
    run.step();
    ::poll(nullptr, 0, 5);
  };
  Browser browser(slow_steps, port_in(run.page()->url()));
  REQUIRE(browser.join() == 101);
  const auto statuses = [&] {
    std::vector<std::string> out;
    for (const auto& message : browser.messages())
      if (message.kind() == 1 && message.channel() == "status" && message.lab() == 0) out.push_back(message.data());
    return out;
  };
  CHECK(tests::comes_to(slow_steps, [&] { return statuses().size() >= 3; }));
  CHECK(run.steps() < 1000);
  CHECK(on_bus <= 1);
  // Its speed is that of wall time, which is more than half a second between two of them, and less than what was
  // waited.
  const auto all = statuses();
  lab_status_t before, last;
  REQUIRE(hal::decode(std::as_bytes(std::span(all[all.size() - 2])), before));
  REQUIRE(hal::decode(std::as_bytes(std::span(all.back())), last));
  REQUIRE(last.stamp_us > before.stamp_us);
  const double wall_s = static_cast<double>(last.stamp_us - before.stamp_us) * 1e-6 / last.speed;
  CHECK(wall_s > 0.4);
  CHECK(wall_s < 15);
}

TEST_CASE("the page's STOP ends the labs of other processes, too, which let this lab's operator") {
  const tests::TestKeys keys;
  keys.join("shark", "roark");
  const auto keys_of = [&](const std::string& lab) { return "gateway.keys=\"" + keys.of(lab).path().string() + "\""; };
  tests::LabProcesses labs(
      {.overrides = {"arena.use=null", "arena.pace=1.0", "gate.period_s=0.5", "gateway.ordered=[\"operator_command\"]"},
       .by_lab = {{"shark",
                   {keys_of("shark"), "safety.commands_from=[\"roark\"]",
                    "gateway.imports=[\"world\",\"status\",\"operator_command\"]"}},
                  {"roark", {keys_of("roark")}}}});
  labs.start();
  REQUIRE(labs.reached("shark", 1, 300s));
  REQUIRE(labs.reached("roark", 1, 300s));
  const std::string url = printed_url(labs.lab_output("roark"));
  Browser browser(elsewhere, port_in(url));
  REQUIRE(browser.join() == 101);
  browser.say({{"token", token_in(url)}});
  browser.say({{"command", {{"name", "pause"}}}, {"request", 1}});
  REQUIRE(browser.hears("done"));
  const auto audit = [&] { return tests::read_file(labs.directory("shark") / "audit.csv"); };
  CHECK(tests::comes_to(elsewhere, [&] { return audit().find(",roark,pause,admitted") != std::string::npos; }));
  browser.say({{"command", {{"name", "stop"}}}});
  CHECK(labs.lab("roark").wait(300s) == 3);
  CHECK(labs.lab("shark").wait(300s) == 3);
  CHECK(audit().find(",roark,stop,admitted") != std::string::npos);
}

TEST_CASE("who has the token of a lab's page commands it as its own operator, and nobody else") {
  tests::LabProcesses labs({.labs = {"shark"}, .overrides = {"arena.use=null", "arena.pace=1.0", "gate.period_s=0.5"}});
  labs.start();
  REQUIRE(labs.reached("shark", 1, 300s));
  const std::string url = printed_url(labs.lab_output("shark"));
  REQUIRE_FALSE(url.empty());
  Browser browser(elsewhere, port_in(url)), stranger(elsewhere, port_in(url));
  REQUIRE(browser.join() == 101);
  REQUIRE(stranger.join() == 101);
  CHECK(hears_channel(browser, "poses"));
  CHECK(hears_channel(browser, "status"));
  CHECK(hears_channel(browser, "arena"));  // said long before
  CHECK(browser.said("hello")["labs"] == json{"shark"});
  stranger.say({{"command", {{"name", "stop"}}}});
  CHECK(stranger.hears("refused"));
  stranger.say({{"token", "a guess"}});
  CHECK(browser.said("hello")["folder"] == labs.directory("shark").string());
  browser.say({{"token", token_in(url)}});
  browser.say({{"command", {{"lab", 0}, {"name", "pause"}}}, {"request", 1}});
  REQUIRE(browser.hears("done"));
  browser.say({{"command", {{"lab", 0}, {"name", "reset"}}}, {"request", 3}});
  CHECK(tests::comes_to(elsewhere, [&] { return browser.said("done")["request"] == 3; }));
  browser.say({{"command", {{"lab", 0}, {"name", "arm"}}}, {"request", 2}});
  REQUIRE(browser.hears("refused"));
  CHECK(browser.said("refused")["why"].get<std::string>().find("commands_from names no lab") != std::string::npos);
  browser.say({{"command", {{"lab", 7}, {"name", "stop"}}}});
  browser.say({{"command", {{"lab", 0}, {"name", "dance"}}}});
  browser.say({{"command", "stop"}});
  browser.say({{"fault", {{"lab", 0}, {"line", "ohc unplug"}}}});
  browser.say({{"move", {{"lab", 0}, {"robot", 1}, {"x_m", 0}, {"y_m", 0}}}});
  CHECK(labs.lab("shark").running());
  browser.say({{"command", {{"name", "stop"}}}});
  CHECK(labs.lab("shark").wait(300s) == 3);
  const std::string audit = tests::read_file(labs.directory("shark") / "audit.csv");
  CHECK(audit.find(",,pause,admitted") != std::string::npos);
  CHECK(audit.find(",,reset,admitted") != std::string::npos);
  CHECK(audit.find(",,arm,no_peers") != std::string::npos);
  CHECK(audit.find(",,stop,admitted") != std::string::npos);
  // What no lab heard of has a row, too, without the words that others chose.
  CHECK(audit.find(",,stop,no_token from 127.0.0.1\n") != std::string::npos);
  CHECK(audit.find(",,,wrong_token from 127.0.0.1\n") != std::string::npos);
  CHECK(audit.find(",,stop,unknown\n") != std::string::npos);
  CHECK(audit.find(",,,unknown\n") != std::string::npos);
  CHECK(audit.find("dance") == std::string::npos);
  const json result = json::parse(tests::read_file(labs.directory("shark") / "result.json"));
  CHECK(result["counters"]["view.refused.no_token"] == 1);
  CHECK(result["counters"]["view.viewers"] == 2);
}

TEST_CASE("two labs on a machine have a page each, and another process shows one of them from its bus") {
  tests::LabProcesses labs({.labs = {"shark", "roark"}, .overrides = {"arena.use=null", "arena.pace=1.0"}});
  labs.start();
  REQUIRE(labs.reached("shark", 1, 300s));
  REQUIRE(labs.reached("roark", 1, 300s));
  const std::string shark = printed_url(labs.lab_output("shark")), roark = printed_url(labs.lab_output("roark"));
  REQUIRE_FALSE(shark.empty());
  REQUIRE_FALSE(roark.empty());
  CHECK(port_in(shark) != port_in(roark));
  CHECK((labs.lab_output("shark") + labs.lab_output("roark")).find("is taken; the page is at") != std::string::npos);
  const tests::TemporaryFolder folder;
  tests::Process view(ARKMESH_PROGRAM, {"view", labs.bus_url("roark"), "--port", "8950"}, folder.path() / "said.txt");
  REQUIRE(tests::eventually(300s, [&] { return !printed_url(view.output()).empty(); }));
  CHECK(view.output().find("token") == std::string::npos);
  Browser browser(elsewhere, port_in(printed_url(view.output())));
  REQUIRE(browser.join() == 101);
  CHECK(hears_channel(browser, "poses"));
  CHECK(hears_channel(browser, "status"));
  CHECK(tests::comes_to(elsewhere, [&] { return !browser.said("events").is_null(); }));
  Browser later(elsewhere, port_in(printed_url(view.output())));
  REQUIRE(later.join() == 101);
  REQUIRE(later.hears("hello"));
  CHECK(later.said("hello")["labs"] == json{"roark"});
  CHECK(later.said("hello")["control"] == false);
  view.signal(SIGTERM);
  CHECK(view.wait(300s) == 0);
}

TEST_CASE("a page's key is made once and kept where nobody else reads it") {
  const tests::TemporaryFolder folder;
  ::setenv("XDG_CONFIG_HOME", folder.path().c_str(), 1);
  const std::string made = app::view_identity("shark", {"192.0.2.7"});
  CHECK(app::view_identity("shark", {"192.0.2.7"}) == made);
  const auto file = folder.path() / "arkmesh/page-shark.pem";
  CHECK(tests::read_file(file) == made);
  CHECK((std::filesystem::status(file).permissions() & std::filesystem::perms(077)) == std::filesystem::perms::none);
  CHECK(app::view_identity("roark", {"192.0.2.7"}) != made);
  std::filesystem::permissions(file, std::filesystem::perms(0644));
  CHECK_THROWS_WITH_AS(app::view_identity("shark", {"192.0.2.7"}), doctest::Contains("can be read or changed by other"),
                       hal::ConfigError);
  ::unsetenv("XDG_CONFIG_HOME");
}

TEST_CASE("[view] is checked") {
  const tests::TemporaryFolder folder;
  const auto refusal = [&](const std::string& set) {
    tests::Process lab(ARKMESH_PROGRAM,
                       {"run", ARKMESH_SOURCE_DIR "/experiments/dhtf/shark.toml", "--set", "arena.use=null", "--set",
                        set, "--out", (folder.path() / "out").string()},
                       folder.path() / "said.txt");
    CHECK(lab.wait(300s) == 2);
    CHECK_FALSE(std::filesystem::exists(folder.path() / "out"));
    return lab.output();
  };
  CHECK(refusal("view.address=\"everywhere\"").find("is not an IP address") != std::string::npos);
  CHECK(refusal("view.port=0").find("view.port") != std::string::npos);
  CHECK(refusal("view.prot=1").find("view.port") != std::string::npos);  // did you mean
}

TEST_CASE("runs without a page print no address, and neither does a batch") {
  const tests::TemporaryFolder folder;
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--set", "view.use=false"}, {"--seeds", "1..2"}}) {
    std::vector<std::string> words = {more.front() == "--seeds" ? "batch" : "run",
                                      ARKMESH_SOURCE_DIR "/experiments/dhtf/shark.toml",
                                      "--set",
                                      "arena.use=null",
                                      "--set",
                                      "run.duration_s=10",
                                      "--out",
                                      (folder.path() / more.back()).string()};
    words.insert(words.end(), more.begin(), more.end());
    tests::Process run(ARKMESH_PROGRAM, words, folder.path() / "said.txt");
    CHECK(run.wait(300s) == 0);
    CHECK(run.output().find("http://") == std::string::npos);
  }
}
