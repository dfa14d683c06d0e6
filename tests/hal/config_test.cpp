// Structs read, checked, written and listed by one visit; what is wrong in a file is said in one sentence.
#include "hal/config/config.hpp"

#include <doctest/doctest.h>

#include <chrono>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh::hal;
using arkmesh::tests::TemporaryDirectory;

namespace {

struct Peer {
  std::string lab;
  double weight = 0.1;

  void fields(const Section& peer) {
    peer.field("lab", lab, {.sample = "\"roark\"", .required = true});
    peer.field("weight", weight, {.range = {0, 1}});
  }
};

enum class Kind { round, square };

struct ArenaKeys {
  int robots = 1;
  double width_m = 0.1, height_m = std::numeric_limits<double>::quiet_NaN();
  bool lit = false;
  Kind kind = Kind::square;
  std::chrono::microseconds frame{100'000};
  std::filesystem::path program;
  std::vector<std::filesystem::path> sources, folders;
  std::vector<std::string> words{"a", "b"};
  std::vector<double> places;
  std::vector<std::int64_t> counts{1, 2};
  std::string name;
  std::vector<Peer> peers;
  std::map<std::string, double, std::less<>> scale;

  void fields(const Section& arena) {
    arena.field("robots", robots, {.range = {0, 9}, .unit = "robots", .help = "how many"});
    arena.field("width_m", width_m, {.range = {.high = 100}});
    arena.field("height_m", height_m, {.default_is = "width_m"});
    arena.field("lit", lit);
    arena.field("kind", kind, {.one_of = {"round", "square"}});
    arena.field("frame_s", frame);
    arena.field("program", program);
    arena.field("sources", sources);
    arena.field("folders", folders);
    arena.field("words", words);
    arena.field("places", places, {.range = {0, 5}});
    arena.field("counts", counts);
    arena.field("name", name);
    arena.field("peers", peers);
    arena.field("scale", scale, {.range = {.low = 0}});
  }
  void check(const Section& arena) {
    if (height_m != height_m) height_m = width_m;
    if (robots == 7) arena.refuse("robots", "must not be seven");
  }
};

std::string refusal(const std::function<void()>& read) {
  try {
    read();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

std::string refusal(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return refusal([&] {
    const Config config = Config::from_text(text, "a.toml", overrides);
    config.root().section("arena").read<ArenaKeys>();
    config.refuse_unknown();
  });
}

std::string without_comment(const std::string& text) {
  return text.substr(text.find('\n'));
}

}  // namespace

TEST_CASE("a struct that gains a key has it read, checked, written, listed and in the sample") {
  // ArenaKeys's keys with one more: nothing but a line of fields() says so.
  struct More : ArenaKeys {
    double added_m = 0.30000000000000004;
    void fields(const Section& arena) {
      ArenaKeys::fields(arena);
      arena.field("added_m", added_m, {.range = {0, 5}, .unit = "m", .help = "a new one"});
    }
  };
  const Config config = Config::from_text("[arena]\nadded_m = 2\n", "a.toml");
  CHECK(config.root().section("arena").read<More>().added_m == 2);
  config.refuse_unknown();
  CHECK(config.effective().find("added_m = 2.0\n") != std::string::npos);
  CHECK(config.in_force_below("arena").at("arena.added_m") == "2.0");
  CHECK(refusal([] { Config::from_text("[arena]\nadded_m = 6", "a.toml").root().section("arena").read<More>(); }) ==
        "a.toml:2: arena.added_m = 6: must be between 0 and 5");
  CHECK(refusal("[arena]\nadded_m = 2\n").starts_with("a.toml:2: unknown key 'arena.added_m'"));
  const auto rows = keys_of<More>("arena");
  CHECK(print_keys(rows).find("| `arena.added_m` | a number | m | `0.30000000000000004` | 0 to 5 | a new one |\n") !=
        std::string::npos);
  // the sample is the defaults
  const std::string sample = print_sample(rows);
  CHECK(sample.find("# a new one [m]; 0 to 5\nadded_m = 0.30000000000000004\n") != std::string::npos);
  const Config again = Config::from_text(sample, "sample.toml"), empty = Config::from_text("", "empty.toml");
  for (const Config* one : {&again, &empty}) {
    CHECK(one->root().section("arena").read<More>().added_m == 0.30000000000000004);
    one->refuse_unknown();
  }
  CHECK(without_comment(again.effective()).starts_with(without_comment(empty.effective()).substr(0, 20)));
}

TEST_CASE("every kind of key is read, and the effective configuration says the same again") {
  // Also elsewhere; whole numbers for a number, derived defaults, names of the user's, and letters beyond ASCII.
  const Config config = Config::from_text(R"([arena]
robots = 3
width_m = 2
lit = true
kind = "round"
frame_s = 0.25
program = "../x.c"
sources = ["../x.c", "y.c"]
folders = "headers"
words = []
places = [1, 0.1]
counts = [7]
name = "sh\"ark\n\u0001é"
scale.roark = 1e-7
[[arena.peers]]
lab = "b"
[[arena.peers]]
lab = "c"
weight = 1
)",
                                          "/somewhere/a.toml");
  const auto read = [](const Config& one) {
    auto arena = one.root().section("arena").read<ArenaKeys>();
    one.refuse_unknown();
    return arena;
  };
  const ArenaKeys arena = read(config);
  CHECK(arena.height_m == 2);
  CHECK(arena.kind == Kind::round);
  CHECK(arena.frame == std::chrono::milliseconds(250));
  CHECK(arena.program == "/x.c");
  CHECK(arena.sources == std::vector<std::filesystem::path>{"/x.c", "/somewhere/y.c"});
  CHECK(arena.folders == std::vector<std::filesystem::path>{"/somewhere/headers"});
  CHECK(arena.places == std::vector<double>{1, 0.1});
  CHECK(arena.peers.at(1).weight == 1);
  CHECK(arena.scale.at("roark") == 1e-7);
  const Config again = Config::from_text(config.effective(), "/elsewhere/b.toml");
  CHECK(read(again).name == "sh\"ark\n\x01é");
  CHECK(without_comment(again.effective()) == without_comment(config.effective()));
  CHECK(again.in_force_below("arena") == config.in_force_below("arena"));
  CHECK(config.in_force_below("arena").at("arena.width_m") == "2.0");
}

TEST_CASE("each bad value is refused in one sentence with file, line and key") {
  // One bad configuration per rule; the whole message is compared.
  const std::pair<std::string, std::string> rows[] = {
      {"[arena]\nrobots = \"many\"", "a.toml:2: arena.robots = \"many\": must be a whole number"},
      {"[arena]\nrobots = 3.0", "a.toml:2: arena.robots = 3.0: must be a whole number"},
      {"[arena]\nrobots = 10", "a.toml:2: arena.robots = 10: must be between 0 and 9"},
      {"[arena]\nrobots = 7", "a.toml:2: arena.robots = 7: must not be seven"},
      {"[arena]\nwidth_m = true", "a.toml:2: arena.width_m = true: must be a number"},
      {"[arena]\nwidth_m = nan", "a.toml:2: arena.width_m = nan: must be a finite number"},
      {"[arena]\nwidth_m = 101.5", "a.toml:2: arena.width_m = 101.5: must be at most 100"},
      {"[arena]\nwidth_m = { x = 1 }", "a.toml:2: arena.width_m: must be a number, not a table"},
      {"[arena]\nlit = 1", "a.toml:2: arena.lit = 1: must be true or false"},
      {"[arena]\nname = 2024-01-02", "a.toml:2: arena.name = 2024-01-02: must be a text in quotes"},
      {"[arena]\nkind = \"odd\"", "a.toml:2: arena.kind = \"odd\": must be one of \"round\", \"square\""},
      {"[arena]\nframe_s = 1e-7", "a.toml:2: arena.frame_s = 1e-07: must be a whole number of microseconds"},
      {"[arena]\nprogram = \"a\\u0000b\"", "a.toml:2: arena.program = \"a\\u0000b\": must be a path"},
      {"[arena]\nsources = [\"a.c\", 1]",
       "a.toml:2: arena.sources = [ \"a.c\", 1 ]: must be a path, or a list of paths"},
      {"[arena]\nsources = [\"a.c\", \"\"]",
       "a.toml:2: arena.sources = [ \"a.c\", \"\" ]: must not contain an empty path"},
      {"[arena]\nwords = [\"a\", 1]", "a.toml:2: arena.words = [ \"a\", 1 ]: must be a list of texts"},
      {"[arena]\nwords = \"a\"", "a.toml:2: arena.words = \"a\": must be a list of texts"},
      {"[arena]\nplaces = [1, 7]", "a.toml:2: arena.places = [ 1, 7 ]: each must be between 0 and 5"},
      {"[arena]\ncounts = [1.5]", "a.toml:2: arena.counts = [ 1.5 ]: must be a list of whole numbers"},
      {"[arena]\nscale.b = -1", "a.toml:2: arena.scale.b = -1: must be at least 0"},
      {"\narena = 3", "a.toml:2: arena = 3: must be a table"},
      {"[[arena]]\nrobots = 1", "a.toml:1: arena = [ { robots = 1 } ]: must be a single table, [arena]"},
      {"[arena]\n[arena.peers]\nlab = \"b\"",
       "a.toml:2: arena.peers: must be a list of tables, each beginning with [[arena.peers]]"},
      {"\n[[arena.peers]]\nweight = 1",
       "a.toml:2: arena.peers[0].lab: is missing; it must be a text in quotes, such as \"roark\""},
      {"[[arena.peers]]\nlab = \"b\"\nwieght = 1",
       "a.toml:3: unknown key 'arena.peers[0].wieght'; did you mean 'arena.peers[0].weight'?"},
      {"[arena]\nwidth_cm = 100", "a.toml:2: unknown key 'arena.width_cm'; did you mean 'arena.width_m'?"},
      {"[arena]\nrobtos = 1", "a.toml:2: unknown key 'arena.robtos'; did you mean 'arena.robots'?"},
      {"[arena]\ncolour = 1", "a.toml:2: unknown key 'arena.colour'; remove it or correct its name"},
      {"[\"none.toml\"]\nx = 1", "a.toml:1: unknown table 'none.toml'; remove it or correct its name"},
      {"[arena]\n\n[aerna]\n", "a.toml:3: unknown table 'aerna'; did you mean 'arena'?"},
      {"[arena]\nx = = 1", "a.toml:2: not valid TOML: Error while parsing value: could not determine value type"},
      {"[!]", "a.toml: not valid TOML; look for stray characters in [table] headers and keys"},
  };
  for (const auto& [text, message] : rows) CHECK(refusal(text) == message);
  CHECK(refusal("[arena]\nlit = \"" + std::string(5000, 'a') + "\"").size() < 200);
}

TEST_CASE("overrides set single keys, a bare word is a text, and errors name the override") {
  const std::string text = "[lab]\nname = \"shark\"\n[arena]\nrobots = 1\n";
  const Config config = Config::from_text(
      text, "a.toml", {"arena.robots=5", "arena.name=plain word", " arena.kind = \"round\"", "shark:arena.lit=true"});
  const auto arena = config.root().section("arena").read<ArenaKeys>();
  CHECK(arena.robots == 5);
  CHECK(arena.name == "plain word");
  CHECK(arena.kind == Kind::round);
  CHECK(arena.lit);
  const std::pair<std::string, std::string> rows[] = {
      {"arena.robots=many", "--set arena.robots=many: arena.robots = \"many\": must be a whole number"},
      {"arena.robtos=1", "--set arena.robtos=1: unknown key 'arena.robtos'; did you mean 'arena.robots'?"},
      {"arena.robots", "--set arena.robots: must look like key=value, for example arena.robots=48"},
      {"roark:arena.robots=1", "--set roark:arena.robots=1: is for lab roark, but this file belongs to lab 'shark'"},
  };
  for (const auto& [one, message] : rows) {
    const std::string said = refusal([&, set = one] {
      const Config bad = Config::from_text(text, "a.toml", {set});
      bad.root().section("lab").get("name", std::string());
      bad.root().section("arena").read<ArenaKeys>();
      bad.refuse_unknown();
    });
    CHECK(said == message);
  }
  for (const char* bad : {"=1", "arena..robots=1", "arena.robots=[1"})
    CHECK(refusal(text, {bad}).substr(0, std::string(bad).size() + 24) ==
          std::string("--set ") + bad + ": not valid TOML: ");
}

TEST_CASE("preset below includes below the file below overrides, each with its own place and folder") {
  // A preset and a path are looked up beside the file that holds them, whichever includes it.
  TemporaryDirectory directory;
  directory.write("shared/presets/paper.toml", "[v]\na = \"preset\"\nb = \"preset\"\nc = \"preset\"\nd = \"preset\"\n");
  directory.write("shared/presets/other.toml", "[v]\na = \"other\"\n");
  directory.write("shared/common.toml", "include = [\"base.toml\"]\n[v]\nb = \"common\"\nc = \"common\"\n");
  directory.write("shared/base.toml", "preset = \"paper\"\n[v]\nb = \"base\"\ne = \"base\"\np = \"x.c\"\n");
  const auto file = directory.write("mine/lab.toml", "include = [\"../shared/common.toml\"]\n[v]\nc = \"file\"\n");
  const Config config = Config::from_file(file, {"v.d=override"});
  const Section v = config.root().section("v");
  const auto read = [](const Section& section, const char* key) { return section.get(key, std::string()); };
  const std::string at = directory.path().string();
  const std::string expected[][3] = {{"a", "preset", at + "/shared/presets/paper.toml:2"},
                                     {"b", "common", at + "/shared/common.toml:3"},
                                     {"c", "file", file.string() + ":3"},
                                     {"d", "override", "--set v.d=override"},
                                     {"e", "base", at + "/shared/base.toml:4"}};
  for (const auto& [key, value, place] : expected) {
    CHECK(read(v, key.c_str()) == value);
    CHECK(refusal([&, key = key] { v.refuse(key, "no"); }).starts_with(place + ": v." + key));
  }
  CHECK(v.get("p", std::filesystem::path()) == directory.path() / "shared/x.c");
  config.refuse_unknown();
  CHECK(config.effective().find(" with preset \"paper\"") != std::string::npos);
  CHECK(read(Config::from_file(file, {"preset=other"}).root().section("v"), "a") == "other");
  CHECK(read(Config::from_file(file, {"preset="}).root().section("v"), "a").empty());
  CHECK(refusal([&] { Config::from_file(file, {"preset=papre"}); }) ==
        "--set preset=papre: preset = \"papre\": there is no such preset in " + at +
            "/shared/presets; there are: other, paper");
}

TEST_CASE("what a key was in a lower layer leaves no trace, and lists of tables are replaced as a whole") {
  TemporaryDirectory directory;
  directory.write("base.toml", "arena = 1\nx = {y = 2}\n");
  const auto file = directory.write("lab.toml", "include = [\"base.toml\"]\nx = 2\n[[arena.peers]]\nlab = \"three\"\n");
  directory.write("again.toml", "include = [\"lab.toml\"]\n[[arena.peers]]\nlab = \"four\"\n");
  const Config config = Config::from_file(directory.path() / "again.toml");
  const auto arena = config.root().section("arena").read<ArenaKeys>();
  REQUIRE(arena.peers.size() == 1);
  CHECK(arena.peers[0].lab == "four");
  CHECK(config.root().get("x", 0) == 2);
  config.refuse_unknown();
}

TEST_CASE("the table of a choice not made is left alone") {
  const Config config = Config::from_text("[arena]\n[arena.ode]\nwhatever = 1\n[arena.ode.more]\nx = 1\n", "a.toml");
  config.root().section("arena").read<ArenaKeys>();
  CHECK_THROWS_AS(config.refuse_unknown(), ConfigError);
  config.root().section("arena").leave_alone("ode");
  config.refuse_unknown();
  CHECK(config.effective().find("ode") == std::string::npos);
  // who reads one key does not answer for the others, until the table is taken up
  CHECK(config.root().section("arena").section("ode").get("whatever", 0) == 1);
  config.refuse_unknown();
  CHECK(config.effective().find("whatever = 1") != std::string::npos);
  config.root().section("arena").take_up("ode");
  CHECK_THROWS_AS(config.refuse_unknown(), ConfigError);
}

TEST_CASE("bad files are refused with the line that asked") {
  // Absent, in a ring, too many, of wrong type, too large, with an error inside, hostile.
  TemporaryDirectory directory;
  const std::string at = directory.path().string() + "/";
  std::string many = "include = [", dotted = "a";
  for (int i = 0; i < 70; ++i) many += "\"leaf.toml\", ";
  for (int i = 0; i < 100'000; ++i) dotted += ".a";
  directory.write("leaf.toml", "");
  directory.write("ring.toml", "include = [\"./lab.toml\"]");
  directory.write("large.toml", std::string(10 << 20, '#'));
  directory.write("broken.toml", "\n\nx = ");
  const std::string rows[][2] = {
      {"\ninclude = [\"none.toml\"]", "lab.toml:2: include = \"none.toml\": there is no file " + at + "none.toml"},
      {"include = \"leaf.toml\"",
       "lab.toml:1: include = \"leaf.toml\": must be a list of file names, such as [\"common.toml\"]"},
      {"include = [3]", "lab.toml:1: include = [ 3 ]: must be a list of file names, such as [\"common.toml\"]"},
      {"include = [\"ring.toml\"]",
       "ring.toml:1: include = \"./lab.toml\": " + at + "lab.toml includes itself; remove one of the includes"},
      {many + "]", "lab.toml:1: include = \"leaf.toml\": more than 64 files included"},
      {"include = [\".\"]", "lab.toml:1: include = \".\": " + at + " is not a text file"},
      {"include = [\"large.toml\"]",
       "lab.toml:1: include = \"large.toml\": " + at + "large.toml is larger than 1 MiB; is it a configuration file?"},
      {"include = [\"broken.toml\"]", "broken.toml:3: not valid TOML: "},
      {"x = " + std::string(100'000, '['), "lab.toml:1: not valid TOML: "},
      {"[" + dotted + "]", "lab.toml: a key has more than 32 dots"},
      {"x = { y = 'é', " + dotted + " = 1 }", "lab.toml: a key has more than 32 dots"},
      {"x = \"\xff\xfe\"", "lab.toml:1: not valid TOML: "},
      {"\xff = 1", "lab.toml:1: not valid TOML: "},
      {"x = 1\nx = 2", "lab.toml:2: not valid TOML: "},
  };
  for (const auto& row : rows) {
    const auto& [text, message] = row;
    CAPTURE(row[1]);
    const auto file = directory.write("lab.toml", text);
    CHECK(refusal([&] { Config::from_file(file); }).starts_with(at + message));
  }
  // twice the same file without a ring is fine, and so is any character and any number of dots in texts and comments
  const std::string dots(500, '.');
  Config::from_file(directory.write("lab.toml", "include = [\"leaf.toml\", \"leaf.toml\"]\n# é " + dots +
                                                    "\na = \"é # '" + dots + "\"\nb = '''\né''" + dots + "'''\n"));
}
