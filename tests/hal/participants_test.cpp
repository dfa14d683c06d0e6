// Which lab a file is of and with whom it shares a world: defaults, and every rule that a file can break.
#include "hal/bus/participants.hpp"

#include <doctest/doctest.h>

#include <string>
#include <vector>

using namespace arkmesh;

namespace {

hal::Participants read(const std::string& keys) {
  return hal::Config::from_text(keys, "shark.toml").root().read<hal::Participants>();
}

}  // namespace

TEST_CASE("participants: a lab alone owns its world, and the first of several does") {
  CHECK(read("lab.name = \"shark\"").labs == std::vector<std::string>{"shark"});
  CHECK(read("lab.name = \"shark\"").owner == "shark");
  const hal::Participants two = read("lab.name = \"shark\"\nshared.labs = [\"shark\", \"roark\"]");
  CHECK(two.labs == std::vector<std::string>{"roark", "shark"});
  CHECK(two.owner == "roark");
  CHECK(read("lab.name = \"shark\"\nshared.labs = [\"shark\", \"roark\"]\nshared.owner = \"shark\"").owner == "shark");
}

TEST_CASE("participants: what no lab takes is refused with its place") {
  const auto refused = [](const std::string& keys, const std::string& sentence) {
    CHECK_THROWS_WITH(read(keys), doctest::Contains(sentence.c_str()));
  };
  const std::string shark = "lab.name = \"shark\"\nshared.labs = ";
  std::string many;
  for (int lab = 0; lab < 64; ++lab) many += "\"lab" + std::to_string(lab) + "\", ";
  refused("", "lab.name");
  refused("lab.name = \"Shark\"", "shark.toml:1: lab.name = \"Shark\": must be 1 to 15 of the characters a-z 0-9 _ -");
  refused("lab.name = \"sharks-and-roarks\"", "must be 1 to 15 of the characters");
  refused(shark + "[\"shark\", \"A\"]", "'A' is not a lab name");
  refused(shark + "[\"shark\", \"shark\"]", "names a lab twice");
  refused(shark + "[" + many + "\"shark\"]", "names more than 64 labs");
  refused(shark + "[\"roark\"]", "does not name this lab, 'shark'; add it or correct lab.name");
  refused(shark + "[\"shark\"]\nshared.owner = \"roark\"",
          "shared.owner = \"roark\": must be one of shared.labs (shark)");
}
