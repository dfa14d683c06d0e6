// Files, includes, presets, paths, and the effective configuration that loads again.
#include <doctest/doctest.h>

#include <functional>
#include <string>
#include <vector>

#include "hal/config.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh::hal;
using arkmesh::tests::TemporaryDirectory;

namespace {

std::string complaint(const std::filesystem::path& file, const std::vector<std::string>& overrides = {}) {
  try {
    Config::from_file(file, overrides);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

// Reads what the experiment files of this test hold.
void read_all(const Config& config) {
  const Section root = config.root();
  root.section("lab").text("name", "");
  root.section("gate").number("period_s", 9);
  root.section("gate").integer("slack", 0);
  root.section("arena").path("controller", "");
  root.section("arena").numbers("start", {});
  for (const Section& peer : root.section("gateway").sections("peers"))
    peer.text("lab", ""), peer.text("connect", "none");
  for (const std::string& lab : root.section("shared").names_below("projection"))
    if (lab != "lynx") root.section("shared").section("projection").section(lab).number("scale", 1);
  config.refuse_unknown();
}

}  // namespace

TEST_CASE("preset below includes below the file below overrides") {
  // Each layer replaces single keys of the layer under it; errors name the file that holds the value in force.
  TemporaryDirectory directory;
  directory.write("presets/paper.toml", "[v]\na = \"preset\"\nb = \"preset\"\nc = \"preset\"\nd = \"preset\"\n");
  directory.write("common.toml", "include = [\"base.toml\"]\n[v]\nb = \"common\"\nc = \"common\"\nd = \"common\"\n");
  directory.write("base.toml", "preset = \"paper\"\n[v]\nb = \"base\"\ne = \"base\"\n");
  const auto file = directory.write("lab.toml", "include = [\"common.toml\"]\n[v]\nc = \"file\"\nd = \"file\"\n");
  const Config config = Config::from_file(file, {"v.d=override"});
  const Section v = config.root().section("v");
  CHECK(v.text("a", "") == "preset");
  CHECK(v.text("b", "") == "common");
  CHECK(v.text("c", "") == "file");
  CHECK(v.text("d", "") == "override");
  CHECK(v.text("e", "") == "base");
  config.refuse_unknown();
  const auto message = [&](const char* key) {
    try {
      v.refuse(key, "no");
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
  };
  CHECK(message("a") == (directory.path() / "presets/paper.toml").string() + ":2: v.a = \"preset\": no");
  CHECK(message("b") == (directory.path() / "common.toml").string() + ":3: v.b = \"common\": no");
  CHECK(message("c") == file.string() + ":3: v.c = \"file\": no");
  CHECK(message("d") == "--set v.d=override: v.d = \"override\": no");
}

TEST_CASE("a preset can be chosen by override and an unknown one lists those there are") {
  // The override replaces the file's choice, and "" takes none.
  TemporaryDirectory directory;
  directory.write("presets/paper.toml", "x = 1\n");
  directory.write("presets/original.toml", "x = 2\n");
  const auto file = directory.write("lab.toml", "preset = \"paper\"\n");
  CHECK(Config::from_file(file).root().integer("x", 0) == 1);
  CHECK(Config::from_file(file, {"preset=original"}).root().integer("x", 0) == 2);
  CHECK(Config::from_file(file, {"preset="}).root().integer("x", 0) == 0);
  CHECK(complaint(file, {"preset=papre"}) ==
        "--set preset=papre: preset = \"papre\": there is no such preset; there are: original, paper");
  CHECK(complaint(file, {"preset=../lab"}).find("there is no such preset") != std::string::npos);
  CHECK(complaint(file, {"preset=3"}) == "--set preset=3: preset = 3: must be a text");
  directory.write("presets/nested.toml", "preset = \"paper\"\n");
  CHECK(complaint(file, {"preset=nested"}).find("a preset cannot name another one") != std::string::npos);
  TemporaryDirectory empty;
  CHECK(complaint(empty.write("a.toml", "preset = \"paper\"")).find("there are no presets in") != std::string::npos);
}

TEST_CASE("bad includes are refused with the line that asked") {
  // Absent, cyclic, too many, of wrong type, unreadable, too large, and with an error inside.
  TemporaryDirectory directory;
  const std::string at = directory.path().string() + "/";
  CHECK(complaint(at + "none.toml") == at + "none.toml: there is no file " + at + "none.toml");
  CHECK(complaint(directory.write("a.toml", "\ninclude = [\"none.toml\"]")) ==
        at + "a.toml:2: include = \"none.toml\": there is no file " + at + "none.toml");
  CHECK(complaint(directory.write("b.toml", "include = \"none.toml\"")) ==
        at + "b.toml:1: include = \"none.toml\": must be a list of file names, for example [\"common.toml\"]");
  CHECK(complaint(directory.write("c.toml", "include = [3]")).find("must be a list of file names") !=
        std::string::npos);
  directory.write("ring2.toml", "include = [\"./ring1.toml\"]");
  CHECK(complaint(directory.write("ring1.toml", "include = [\"ring2.toml\"]")) ==
        at + "ring2.toml:1: include = \"./ring1.toml\": " + at +
            "ring1.toml includes itself; remove one of the includes");
  directory.write("leaf.toml", "");
  std::string many = "include = [";
  for (int i = 0; i < 70; ++i) many += "\"leaf.toml\", ";
  CHECK(complaint(directory.write("many.toml", many + "]")).ends_with("more than 64 files included"));
  CHECK(complaint(directory.write("d.toml", "include = [\".\"]")).find("is not a file") != std::string::npos);
  directory.write("large.toml", std::string((1 << 20) + 1, '#'));
  CHECK(complaint(directory.write("e.toml", "include = [\"large.toml\"]")).find("is larger than 1 MiB") !=
        std::string::npos);
  directory.write("broken.toml", "\n\nx = ");
  CHECK(complaint(directory.write("f.toml", "include = [\"broken.toml\"]"))
            .starts_with(at + "broken.toml:3: not valid TOML:"));
  // twice the same file without a cycle is fine
  CHECK(complaint(directory.write("g.toml", "include = [\"leaf.toml\", \"leaf.toml\"]")).empty());
}

TEST_CASE("a later layer can turn a value into a table and back") {
  // What a key was in a lower layer leaves no trace; arrays of tables are replaced as a whole.
  TemporaryDirectory directory;
  directory.write("base.toml", "a = 1\n[b]\nx = 1\n[b.c]\ny = 1\n[[p]]\nlab = \"one\"\n[[p]]\nlab = \"two\"\n");
  const auto file =
      directory.write("lab.toml", "include = [\"base.toml\"]\nb = 2\n[a]\nz = 3\n[[p]]\nlab = \"three\"\n");
  const Config config = Config::from_file(file);
  CHECK(config.root().integer("b", 0) == 2);
  CHECK(config.root().section("a").integer("z", 0) == 3);
  const auto p = config.root().sections("p");
  REQUIRE(p.size() == 1);
  CHECK(p[0].text("lab", "") == "three");
  config.refuse_unknown();
}

TEST_CASE("a path is relative to the file that holds it") {
  // In an included file, in the main file, as default, as override.
  TemporaryDirectory directory;
  directory.write("sub/common.toml", "[p]\nincluded = \"x.c\"\n");
  const auto file =
      directory.write("lab.toml", "include = [\"sub/common.toml\"]\n[p]\nown = \"../y.c\"\nabsolute = \"/z.c\"\n");
  const Config config = Config::from_file(file, {"p.override=w.c"});
  const Section p = config.root().section("p");
  CHECK(p.path("included", "") == directory.path() / "sub/x.c");
  CHECK(p.path("own", "") == directory.path().parent_path() / "y.c");
  CHECK(p.path("absolute", "") == "/z.c");
  CHECK(p.path("default", "d.c") == directory.path() / "d.c");
  CHECK(p.path("override", "") == std::filesystem::current_path() / "w.c");
  CHECK(p.path("nothing", "").empty());
}

TEST_CASE("the effective configuration loads on its own elsewhere and says the same") {
  // No include, no preset, absolute paths: a run folder's copy repeats the run.
  TemporaryDirectory directory, elsewhere;
  directory.write("presets/paper.toml", "[gate]\nperiod_s = 2\n[arena]\nstart = [0.5, 1e-7, 3]\n");
  directory.write("common.toml", "[shared.projection.shark]\nscale = 0.1\n[shared.projection.lynx]\nscale = 2\n");
  const auto file = directory.write("lab.toml", R"(include = ["common.toml"]
preset = "paper"
[lab]
name = "sh\"ark\n\u0001é"
[arena]
controller = "../controller.c"
[gateway]
[[gateway.peers]]
lab = "roark"
[[gateway.peers]]
lab = "lynx"
connect = "127.0.0.1:7801"
)");
  const Config first = Config::from_file(file, {"gate.slack=2"});
  read_all(first);
  CHECK(first.effective().find("with preset \"paper\"") != std::string::npos);

  const Config second = Config::from_file(elsewhere.write("deep/effective.toml", first.effective()));
  read_all(second);
  const auto without_comment = [](const std::string& text) { return text.substr(text.find('\n')); };
  CHECK(without_comment(second.effective()) == without_comment(first.effective()));
  for (const char* table : {"lab", "gate", "arena", "gateway", "shared"})
    CHECK(second.in_force_below(table) == first.in_force_below(table));
  CHECK(first.in_force_below("gate") ==
        std::map<std::string, std::string>{{"gate.period_s", "2.0"}, {"gate.slack", "2"}});
  CHECK(second.root().section("lab").text("name", "") == "sh\"ark\n\x01é");
  CHECK(second.root().section("arena").path("controller", "") == directory.path().parent_path() / "controller.c");
}
