// What `arkmesh explain` says: the rule with its place and settings, or what to write.
#include "gateway/explanation.hpp"

#include <doctest/doctest.h>

#include <string>

#include "gateway/config.hpp"

namespace arkmesh::gateway {
namespace {

ChannelRules rules_of(const std::string& text) {
  const hal::Config file = hal::Config::from_text(text, "shark.toml");
  return read_gateway_config(file.root().section("gateway"), "shark", {"roark", "shark"}).rules;
}

const std::string some_rules = R"(
[[gateway.rules]]
deny = "cam_9"
direction = "export"
[[gateway.rules]]
allow = "cam_*"
direction = "export"
delivery = "ordered"
rate_hz = 2.5
bytes_per_s = 1000
[[gateway.rules]]
allow = "tally"
direction = "import"
rate_hz = 4
[[gateway.peers]]
lab = "roark"
connect = "127.0.0.1:1"
)";

TEST_CASE("explain says by which rule a channel passes, and how") {
  const ChannelRules rules = rules_of(some_rules);
  const ExplainedLab shark{"shark", "shark.toml", rules};
  const Explanation camera = explain(shark, Direction::exports, "cam_1", "roark");
  CHECK(camera.passes);
  CHECK(
      camera.text.starts_with("lab shark exports cam_1 to roark as shark/cam_1: rule 2 (gateway.rules[1], "
                              "shark.toml:6: allow = \"cam_*\")\n"));
  for (const char* setting :
       {"  delivery    ordered", "  at most     2.5 messages/s; more wait", "  at most     1000 bytes/s"}) {
    CAPTURE(setting);
    CHECK(camera.text.find(setting) != std::string::npos);
  }
  const Explanation tally = explain(shark, Direction::imports, "tally", "roark");
  CHECK(tally.passes);
  CHECK(tally.text ==
        "lab shark imports tally from roark as roark/tally: rule 3 (gateway.rules[2], shark.toml:12: allow = "
        "\"tally\")\n  at most     4 messages/s; more are refused\n");
  CHECK(explain(shark, Direction::exports, "world", "roark")
            .text.starts_with("lab shark exports world to roark as shark/world: rule 4 (gateway.exports, by default: "
                              "allow = \"world\")\n"));
}

TEST_CASE("explain says why a channel does not pass, and what it writes down lets it pass") {
  const ChannelRules rules = rules_of(some_rules);
  const ExplainedLab shark{"shark", "shark.toml", rules};
  const Explanation denied = explain(shark, Direction::exports, "cam_9", "roark");
  CHECK_FALSE(denied.passes);
  CHECK(
      denied.text.starts_with("lab shark does not export cam_9 to roark: rule 1 (gateway.rules[0], shark.toml:3: deny "
                              "= \"cam_9\") denies it\n  to let it pass, write before that rule in shark.toml:\n"));
  const Explanation unheard = explain(shark, Direction::imports, "poses", "roark");
  CHECK_FALSE(unheard.passes);
  CHECK(
      unheard.text.starts_with("lab shark does not import poses from roark: no rule allows it\n  to let it pass, add "
                               "\"poses\" to gateway.imports in shark.toml, or, for lab roark alone:\n"));
  // What follows the first colon at a line's end goes to the top of the file as it is.
  for (const auto& [way, channel, text] :
       {std::tuple(Direction::exports, "cam_9", denied.text), std::tuple(Direction::imports, "poses", unheard.text)}) {
    const ChannelRules mended = rules_of(text.substr(text.find(":\n") + 2) + some_rules);
    CHECK(explain({"shark", "shark.toml", mended}, way, channel, "roark").passes);
  }
  for (const char* never : {"lynx/world", "a b", "*"})
    CHECK(explain(shark, Direction::exports, never, "roark").text.find("a channel that can cross has") !=
          std::string::npos);
  const ChannelRules stars = rules_of("gateway.exports = [\"*\"]");
  CHECK(explain({"shark", "shark.toml", stars}, Direction::exports, "operator_command", "roark")
            .text.find("no rule allows it, for '*' never means commands to robots") != std::string::npos);
}

}  // namespace
}  // namespace arkmesh::gateway
