// A program of one's own: all commands of arkmesh, and scenarios that only it knows.
#include "cli/whole_program.hpp"

#include <doctest/doctest.h>

#include <fstream>
#include <string>

#include "tests/support/processes/process.hpp"

namespace {

using namespace arkmesh;

TEST_CASE("a program of one's own knows scenarios of its own") {
  // It is asked to make the scenario that the lab's file names, and its refusal ends the command as any other does.
  const tests::TemporaryFolder folder;
  std::string file = folder.path() / "lab.toml", out = folder.path() / "out";
  std::ofstream(file) << "[lab]\nname = \"shark\"\n[run]\nscenario = \"chess\"\n[arena]\nuse = \"null\"\n";
  int asked = 0;
  const auto make = [&asked](const hal::Section& settings,
                             const std::vector<std::string>&) -> std::unique_ptr<lab::Scenario> {
    ++asked;
    settings.refuse("board", "is not set up");
  };
  std::string words[] = {"chess", "run", file, "--out", out};
  char* argv[] = {words[0].data(), words[1].data(), words[2].data(), words[3].data(), words[4].data(), nullptr};
  CHECK(cli::main(5, argv, {{"chess", make}}) == 2);
  CHECK(asked == 1);
  std::erase_if(app::catalogue(), [](const app::CatalogueEntry& entry) { return entry.name == "chess"; });
}

}  // namespace
