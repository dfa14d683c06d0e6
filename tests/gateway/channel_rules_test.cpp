// Channel rules by themselves: patterns, order, who is meant, names that would collide, and what peers are told.
#include "gateway/channel_rules.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "gateway/frame/channel_name.hpp"
#include "hal/random.hpp"

namespace arkmesh::gateway {
namespace {

using enum Direction;

// The same by trying every way to share the name out among the stars.
bool matches_by_trying(std::string_view pattern, std::string_view name) {
  if (pattern.empty()) return name.empty();
  if (pattern[0] != '*')
    return !name.empty() && name[0] == pattern[0] && matches_by_trying(pattern.substr(1), name.substr(1));
  for (std::size_t taken = 0; taken <= name.size(); ++taken)
    if (matches_by_trying(pattern.substr(1), name.substr(taken))) return true;
  return false;
}

TEST_CASE("patterns of channel names") {
  // A table, and all short patterns against all short names.
  for (const auto& [pattern, name] : std::vector<std::pair<std::string, std::string>>{{"world", "world"},
                                                                                      {"*", "world"},
                                                                                      {"*", ""},
                                                                                      {"w*d", "world"},
                                                                                      {"w*d", "wd"},
                                                                                      {"*or*", "world"},
                                                                                      {"a**", "a"}})
    CHECK(matches(pattern, name));
  for (const auto& [pattern, name] : std::vector<std::pair<std::string, std::string>>{
           {"world", "worlds"}, {"worlds", "world"}, {"w*d", "worlds"}, {"", "w"}, {"*x", "world"}, {"w.r", "wor"}})
    CHECK_FALSE(matches(pattern, name));
  const auto words = [](std::string_view letters, int longest) {
    std::vector<std::string> all{""};
    for (std::size_t from = 0; longest > 0; --longest)
      for (const std::size_t to = all.size(); from < to; ++from)
        for (char c : letters) all.push_back(all[from] + c);
    return all;
  };
  int matching = 0, wrong = 0;
  for (const std::string& pattern : words("ab*", 5))
    for (const std::string& name : words("ab", 4)) {
      matching += matches(pattern, name);
      wrong += matches(pattern, name) != matches_by_trying(pattern, name);
    }
  CHECK(wrong == 0);
  CHECK(matching > 1000);
  // Exponential work for a careless matcher; 47 characters are all that a name has.
  CHECK_FALSE(matches("*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*b", std::string(47, 'a')));
}

TEST_CASE("the first rule about a channel decides, and none denies") {
  const ChannelRules rules({{.deny = "secret*"},
                            {.allow = "s*", .peers = {"roark"}},
                            {.deny = "*", .peers = {"roark"}},
                            {.allow = "status"},
                            {.allow = "s*", .direction = imports}});
  const auto number = [&](Direction way, const char* channel, const char* peer) {
    const ChannelRule* rule = rules.about(way, channel, peer);
    return rule ? rule - rules.all().data() : -1;
  };
  CHECK(number(exports, "secret_1", "roark") == 0);
  CHECK(number(exports, "status", "roark") == 1);
  CHECK(number(exports, "world", "roark") == 2);
  CHECK(number(exports, "status", "lynx") == 3);
  CHECK(number(exports, "world", "lynx") == -1);
  CHECK(number(imports, "secret_1", "lynx") == 4);
  CHECK(number(imports, "world", "lynx") == -1);
  CHECK(rules.passing(exports, "status", "roark"));
  CHECK_FALSE(rules.passing(exports, "world", "roark"));
  CHECK_FALSE(rules.passing(exports, "secret_1", "roark"));
}

TEST_CASE("commands to robots pass only by their name") {
  // A denial's star means them, too.
  const ChannelRules by_pattern({{.allow = "*"}, {.allow = "operator*", .direction = imports}});
  const ChannelRules by_name({{.allow = "operator_command"}, {.deny = "*"}, {.allow = "to_robots"}});
  for (const char* channel : {"operator_command", "fleet_command", "to_robots"}) {
    CHECK_FALSE(by_pattern.passing(exports, channel, "roark"));
    CHECK_FALSE(by_pattern.passing(imports, channel, "roark"));
  }
  CHECK(by_pattern.passing(exports, "from_robots", "roark"));
  CHECK(by_name.passing(exports, "operator_command", "roark"));
  CHECK_FALSE(by_name.passing(exports, "to_robots", "roark"));
}

TEST_CASE("peers are told names and patterns, each once") {
  // A name that earlier rules deny for everybody is not told.
  const ChannelRules rules({{.deny = "status"},
                            {.allow = "world", .peers = {"roark"}},
                            {.allow = "cam_*"},
                            {.allow = "poses", .peers = {"lynx"}},
                            {.allow = "cam_*", .peers = {"lynx"}},
                            {.allow = "world"},
                            {.allow = "status"},
                            {.allow = "events", .direction = imports}});
  std::vector<std::string> names;
  for (const ExportedChannel& channel : rules.announced({"roark"})) names.push_back(channel.name);
  CHECK(names == std::vector<std::string>{"world", "cam_*"});
  const auto all = rules.announced({"lynx", "roark"});
  REQUIRE(all.size() == 3);
  CHECK(all[0].name == "world");
  CHECK(all[0].type == exported("world").type);
  CHECK(rules.bus_pattern() == "world|cam_[^/]*|poses|cam_[^/]*|world|status");
}

TEST_CASE("whatever the rules, names stay apart and below their lab") {
  // Random rules: what comes from a peer has exactly one '/', behind the peer's name, and no two names come out alike.
  hal::RandomStream chance(7, "rules");
  const std::vector<std::string> names{"a", "b", "c", "aa", "ab", "ba"}, patterns{"a", "b", "c", "a*", "*b", "*", "ab"};
  const auto pick = [&](const auto& list) { return list[chance.below(list.size())]; };
  int passed = 0;
  for (int round = 0; round < 2000; ++round) {
    std::vector<ChannelRule> all(1 + chance.below(5));
    for (ChannelRule& rule : all) {
      (chance.below(4) == 0 ? rule.deny : rule.allow) = pick(patterns);
      rule.direction = chance.below(2) == 0 ? exports : imports;
      if (chance.below(2) == 0) rule.peers = {"roark"};
    }
    const ChannelRules rules(all);
    for (const Direction way : {exports, imports}) {
      std::vector<std::string> out;
      for (const std::string& name : names)
        if (rules.passing(way, name, "roark")) {
          out.push_back(foreign_name("roark", name));
          ++passed;
        }
      for (const std::string& name : out) {
        if (name.find('/') != 5 || name.rfind('/') != 5 || name.find("roark") != 0) FAIL("escaped: ", name);
        if (std::ranges::count(out, name) != 1) FAIL("two are called ", name);
      }
    }
  }
  CHECK(passed > 2000);
}

}  // namespace
}  // namespace arkmesh::gateway
