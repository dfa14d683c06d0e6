// Reading single keys, and what is said about bad ones. Files, includes and presets: config_file_test.cpp.
#include "hal/config.hpp"

#include <doctest/doctest.h>

#include <functional>
#include <string>
#include <vector>

using namespace arkmesh::hal;

namespace {

// The message that `read` ends with; empty when it ends with none.
std::string complaint(const std::string& text, const std::function<void(const Section&)>& read,
                      const std::vector<std::string>& overrides = {}) {
  try {
    const Config config = Config::from_text(text, "a.toml", overrides);
    read(config.root());
    config.refuse_unknown();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("getters return what the file says") {
  // Every type of value comes back as it was written, integers also as numbers.
  const Config config = Config::from_text(R"(
[a]
number = 2.5
whole  = -7
flag   = true
text   = "x\ty"
texts  = ["p", "q"]
numbers = [1, 2.5]
hex    = 0x10
[a.b]
deep = "d"
)",
                                          "a.toml");
  const Section a = config.root().section("a");
  CHECK(a.number("number", 0) == 2.5);
  CHECK(a.number("whole", 0) == -7.0);
  CHECK(a.integer("whole", 0) == -7);
  CHECK(a.integer("hex", 0) == 16);
  CHECK(a.flag("flag", false));
  CHECK(a.text("text", "") == "x\ty");
  CHECK(a.texts("texts", {}) == std::vector<std::string>{"p", "q"});
  CHECK(a.numbers("numbers", {}) == std::vector<double>{1, 2.5});
  CHECK(a.section("b").required_text("deep") == "d");
  CHECK(a.choice("text", "", {"x\ty", "z"}) == "x\ty");
  config.refuse_unknown();
}

TEST_CASE("getters return defaults for keys that are not there") {
  // An empty file gives every default, and each is part of the effective configuration.
  const Config config = Config::from_text("", "a.toml");
  const Section a = config.root().section("a");
  CHECK(a.number("number", 1.5) == 1.5);
  CHECK(a.integer("whole", 3) == 3);
  CHECK(a.flag("flag", true));
  CHECK(a.text("text", "t") == "t");
  CHECK(a.choice("choice", "one", {"one", "two"}) == "one");
  CHECK(a.texts("texts", {"u"}) == std::vector<std::string>{"u"});
  CHECK(a.numbers("numbers", {0.5}) == std::vector<double>{0.5});
  CHECK(a.path("path", "").empty());
  CHECK(a.sections("tables").empty());
  CHECK(a.names_below("names").empty());
  CHECK(config.in_force_below("a") == std::map<std::string, std::string>{{"a.number", "1.5"},
                                                                         {"a.whole", "3"},
                                                                         {"a.flag", "true"},
                                                                         {"a.text", "\"t\""},
                                                                         {"a.choice", "\"one\""},
                                                                         {"a.texts", "[\"u\"]"},
                                                                         {"a.numbers", "[0.5]"},
                                                                         {"a.path", "\"\""}});
}

TEST_CASE("each bad value is refused in one sentence with file, line and key") {
  // One bad configuration per rule; the whole message is compared.
  struct Row {
    std::string text;
    std::function<void(const Section&)> read;
    std::string message;
  };
  const auto in_arena = [](auto read) { return [read](const Section& root) { read(root.section("arena")); }; };
  const std::vector<Row> rows{
      {"[arena]\nrobots = \"many\"", in_arena([](auto a) { a.integer("robots", 1); }),
       "a.toml:2: arena.robots = \"many\": must be a whole number"},
      {"[arena]\nrobots = 3.0", in_arena([](auto a) { a.integer("robots", 1); }),
       "a.toml:2: arena.robots = 3.0: must be a whole number"},
      {"[arena]\nrobots = 3", in_arena([](auto a) { a.integer("robots", 1, 5, 9); }),
       "a.toml:2: arena.robots = 3: must be between 5 and 9"},
      {"[arena]\nrobots = 3", in_arena([](auto a) { a.integer("robots", 1, 5); }),
       "a.toml:2: arena.robots = 3: must be at least 5"},
      {"[arena]\nwidth_m = true", in_arena([](auto a) { a.number("width_m", 1); }),
       "a.toml:2: arena.width_m = true: must be a number"},
      {"[arena]\nwidth_m = nan", in_arena([](auto a) { a.number("width_m", 1); }),
       "a.toml:2: arena.width_m = nan: must be a finite number"},
      {"[arena]\nwidth_m = -inf", in_arena([](auto a) {
         a.number("width_m", 1, {0, 1});
       }),
       "a.toml:2: arena.width_m = -inf: must be a finite number"},
      {"[arena]\nwidth_m = -1", in_arena([](auto a) {
         a.number("width_m", 1, {0, 100});
       }),
       "a.toml:2: arena.width_m = -1: must be between 0 and 100"},
      {"[arena]\nwidth_m = 101.5", in_arena([](auto a) { a.number("width_m", 1, {.high = 100}); }),
       "a.toml:2: arena.width_m = 101.5: must be at most 100"},
      {"[arena]\nflag = 1", in_arena([](auto a) { a.flag("flag", false); }),
       "a.toml:2: arena.flag = 1: must be true or false"},
      {"[arena]\nuse = 1", in_arena([](auto a) { a.text("use", ""); }),
       "a.toml:2: arena.use = 1: must be a text in quotes"},
      {"[arena]\nuse = 2024-01-02", in_arena([](auto a) { a.text("use", ""); }),
       "a.toml:2: arena.use = 2024-01-02: must be a text in quotes"},
      {"[arena]\nuse = \"odd\"", in_arena([](auto a) {
         a.choice("use", "ode", {"ode", "replay", "null"});
       }),
       "a.toml:2: arena.use = \"odd\": must be \"ode\", \"replay\" or \"null\""},
      {"[arena]\nuse = [\"a\", 1]", in_arena([](auto a) { a.texts("use", {}); }),
       "a.toml:2: arena.use = [\"a\", 1]: must be a list of texts"},
      {"[arena]\nuse = \"a\"", in_arena([](auto a) { a.texts("use", {}); }),
       "a.toml:2: arena.use = \"a\": must be a list of texts"},
      {"[arena]\nat = [1, \"a\"]", in_arena([](auto a) { a.numbers("at", {}); }),
       "a.toml:2: arena.at = [1, \"a\"]: must be a list of numbers"},
      {"[arena]\nat = [1, nan]", in_arena([](auto a) { a.numbers("at", {}); }),
       "a.toml:2: arena.at = [1, nan]: each must be a finite number"},
      {"[arena]\nat = [1, 7]", in_arena([](auto a) {
         a.numbers("at", {}, {0, 5});
       }),
       "a.toml:2: arena.at = [1, 7]: each must be between 0 and 5"},
      {"[arena]\nsize = { x = 1 }", in_arena([](auto a) { a.number("size", 1); }),
       "a.toml:2: arena.size: must be a number, not a table"},
      {"\narena = 3", in_arena([](auto) {}), "a.toml:2: arena = 3: must be a table"},
      {"[[arena]]\nx = 1", in_arena([](auto) {}), "a.toml:1: arena: must be a single table, [arena]"},
      {"[arena]\n[arena.peers]\nx = 1", in_arena([](auto a) { a.sections("peers"); }),
       "a.toml:2: arena.peers: must be a list of tables, each beginning with [[arena.peers]]"},
      {"\n[arena]\nx = 1", in_arena([](auto a) { a.number("x", 1), a.required_text("name"); }),
       "a.toml:2: arena.name is missing; it must be a text"},
      {"", in_arena([](auto a) { a.required_text("name"); }), "a.toml: arena.name is missing; it must be a text"},
      {"[arena]\nlog = \"a\\u0000b\"", in_arena([](auto a) { a.path("log", ""); }),
       "a.toml:2: arena.log = \"a\\u0000b\": must be a path"},
      {"[arena]\nx = 1", in_arena([](auto a) { a.number("x", 0), a.refuse("x", "must be odd"); }),
       "a.toml:2: arena.x = 1: must be odd"},
      {"[arena]\n", in_arena([](auto a) { a.number("x", 4), a.refuse("x", "must be odd"); }),
       "a.toml: arena.x = 4.0: must be odd"},
      // unknown keys and tables
      {"[arena]\nwidth_m = 1\nwidth_cm = 100", in_arena([](auto a) { a.number("width_m", 1); }),
       "a.toml:3: unknown key 'arena.width_cm'; did you mean 'arena.width_m'?"},
      {"[arena]\nwidth = 1", in_arena([](auto a) { a.number("width_m", 1), a.number("height_m", 1); }),
       "a.toml:2: unknown key 'arena.width'; did you mean 'arena.width_m'?"},
      {"[arena]\nrobtos = 1", in_arena([](auto a) { a.integer("robots", 1); }),
       "a.toml:2: unknown key 'arena.robtos'; did you mean 'arena.robots'?"},
      {"[arena]\ncolour = 1", in_arena([](auto a) { a.integer("robots", 1); }),
       "a.toml:2: unknown key 'arena.colour'; remove it or correct its name"},
      {"[arena]\n\n[aerna]\n", in_arena([](auto) {}), "a.toml:3: unknown table 'aerna'; did you mean 'arena'?"},
      {"[arena]\n[[walls]]\nx = 1", in_arena([](auto) {}),
       "a.toml:2: unknown table 'walls'; remove it or correct its name"},
      {"[arena]\n\"wi dth\" = 1", in_arena([](auto a) { a.integer("robots", 1); }),
       "a.toml:2: unknown key 'arena.\"wi dth\"'; remove it or correct its name"},
      // no TOML at all
      {"[arena]\nx = = 1", in_arena([](auto) {}),
       "a.toml:2: not valid TOML: Error while parsing value: could not determine value type"},
      {"\n\xc3\xa9 = 1", in_arena([](auto) {}), "a.toml:2: not valid TOML: a character that may stand in quotes only"},
      {"[!]", in_arena([](auto) {}), "a.toml: not valid TOML; look for stray characters in [table] headers and keys"},
  };
  for (const Row& row : rows) {
    CAPTURE(row.text);
    CHECK(complaint(row.text, row.read) == row.message);
  }
}

TEST_CASE("long values are shortened in messages") {
  // A message stays one readable line whatever the file holds.
  const std::string message =
      complaint("x = \"" + std::string(5000, 'a') + "\"", [](const Section& r) { r.number("x", 0); });
  CHECK(message.size() < 200);
  CHECK(message.find("must be a number") != std::string::npos);
}

TEST_CASE("overrides win and are named in messages") {
  // Values are TOML or bare words; what is wrong with one is said with --set, not with a line of the file.
  const std::string text = "[arena]\nrobots = 1\nuse = \"ode\"\n[[peers]]\nlab = \"a\"\n[[peers]]\nlab = \"b\"\n";
  const Config config = Config::from_text(
      text, "a.toml",
      {"arena.robots=48", " arena.use = null", "arena.at=[1, 2]", "arena.note=\"7\"", "arena.empty=", "peers[1].lab=c",
       "new.deep.key=true", "arena.sub={p = 1, q = 2}", "arena.word=1.2.3", "arena.tricky=1\nx = 2"});
  const Section arena = config.root().section("arena");
  CHECK(arena.integer("robots", 0) == 48);
  CHECK(arena.text("use", "") == "null");
  CHECK(arena.numbers("at", {}) == std::vector<double>{1, 2});
  CHECK(arena.text("note", "") == "7");
  CHECK(arena.text("empty", "x").empty());
  CHECK(arena.text("word", "") == "1.2.3");
  CHECK(arena.text("tricky", "") == "1\nx = 2");
  CHECK(arena.section("sub").integer("q", 0) == 2);
  CHECK(arena.section("sub").integer("p", 0) == 1);
  CHECK(config.root().section("new").section("deep").flag("key", false));
  const auto peers = config.root().sections("peers");
  REQUIRE(peers.size() == 2);
  CHECK(peers[0].text("lab", "") == "a");
  CHECK(peers[1].text("lab", "") == "c");
  config.refuse_unknown();

  const auto read = [](const Section& root) {
    root.section("arena").integer("robots", 0);
    root.section("arena").text("use", "");
    for (const Section& peer : root.sections("peers")) peer.text("lab", "");
  };
  struct Row {
    std::string override_text, message;
  };
  const std::vector<Row> rows{
      {"arena.robots=many", "--set arena.robots=many: arena.robots = \"many\": must be a whole number"},
      {"arena.robtos=1", "--set arena.robtos=1: unknown key 'arena.robtos'; did you mean 'arena.robots'?"},
      {"arena.robots", "--set arena.robots: must look like key=value, for example arena.robots=48"},
      {"=1", "--set =1: '' is no key; it must look like arena.robots"},
      {"arena..robots=1", "--set arena..robots=1: 'arena..robots' is no key; it must look like arena.robots"},
      {"arena.robots.=1", "--set arena.robots.=1: 'arena.robots.' is no key; it must look like arena.robots"},
      {"a b=1", "--set a b=1: 'a b' is no key; it must look like arena.robots"},
      {"peers[2].lab=x", "--set peers[2].lab=x: there is no peers[2] to set a key of"},
      {"peers[0]=x", "--set peers[0]=x: there is no peers[0] to set a key of"},
      {"arena.robots=[1", "--set arena.robots=[1: not valid TOML: Error while parsing array: encountered end-of-file"},
      {"arena.use=\xff", "--set arena.use=\xff: not valid TOML: Encountered invalid utf-8 sequence"},
  };
  for (const Row& row : rows) {
    CAPTURE(row.override_text);
    CHECK(complaint(text, read, {row.override_text}) == row.message);
  }
}

TEST_CASE("keys of neighbours below a listed table are known, their misspellings are not") {
  // A lab that takes no part may keep its table, as long as its keys are those of the labs that do.
  const std::string text = "[projection.shark]\nscale = 1\n[projection.lynx]\nscale = 2\n";
  const auto read = [](const Section& root) {
    const Section projection = root.section("projection");
    CHECK(root.names_below("projection").size() >= 2);
    for (const char* lab : {"roark", "shark"}) projection.section(lab).number("scale", 1);
  };
  CHECK(complaint(text, read).empty());
  CHECK(complaint(text + "sacle = 3\n", read) ==
        "a.toml:5: unknown key 'projection.lynx.sacle'; did you mean 'projection.lynx.scale'?");
  // nothing to compare with: whoever reads no neighbour at all does not care
  CHECK(complaint(text + "sacle = 3\n", [](const Section& root) { root.names_below("projection"); }).empty());
  // the same for keys right below the listed table
  const auto read_values = [](const Section& root) {
    root.names_below("need");
    root.section("need").numbers("shark", {});
  };
  CHECK(complaint("[need]\nshark = [1, 2]\nlynx = [1, 2]\n", read_values).empty());
}

TEST_CASE("the table of a choice not made is left alone") {
  // [arena.ode] may stay in the file when arena.use is "null"; it is no part of the effective configuration.
  const Config config =
      Config::from_text("[arena]\nuse = \"null\"\n[arena.ode]\nwhatever = 1\n[arena.ode.more]\nx = 1\n", "a.toml");
  const Section arena = config.root().section("arena");
  arena.text("use", "");
  CHECK_THROWS_AS(config.refuse_unknown(), ConfigError);
  arena.leave_alone("ode");
  config.refuse_unknown();
  CHECK(config.effective().find("ode") == std::string::npos);
}

TEST_CASE("has() tells whether a key is there and makes it known") {
  // Also for tables; and what has() found absent stays absent in the effective configuration.
  const Config config = Config::from_text("x = 1\n[t]\n", "a.toml");
  CHECK(config.root().has("x"));
  CHECK(config.root().has("t"));
  CHECK(!config.root().has("y"));
  config.root().number("y", 5);
  config.root().number("x", 5);
  config.refuse_unknown();
  const Config again = Config::from_text(config.effective(), "b.toml");
  CHECK(again.root().has("x"));
  CHECK(again.root().has("t"));
  CHECK(!again.root().has("y"));
}

TEST_CASE("texts and comments may hold any character and any number of dots") {
  // The first look at the text follows quotes as TOML does.
  const std::string dots(500, '.');
  const Config config = Config::from_text("\xEF\xBB\xBF# \xc3\xa9 \" ' " + dots + R"(
a = "é # ' \" )" + dots + R"("
b = 'é " # \' # "
c = ""  # é
d = """
é " "" \"" )" + dots + R"(
é"""""
e = '''é'''''  # é
f = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 2.0, 2.1, 2.2, 2.3, 2.4, 2.5,
  2.6, 2.7, 2.8, 2.9, 3.0, 3.1, 3.2, 3.3, 3.4, 3.5, 3.6, 3.7, 3.8, 3.9]
)",
                                          "a.toml");
  const Section root = config.root();
  CHECK(root.text("a", "") == "é # ' \" " + dots);
  CHECK(root.text("b", "") == "é \" # \\");
  CHECK(root.text("c", "x").empty());
  CHECK(root.text("d", "") == "é \" \"\" \"\" " + dots + "\né\"\"");
  CHECK(root.text("e", "") == "é''");
  CHECK(root.numbers("f", {}).size() == 39);
  config.refuse_unknown();
}

TEST_CASE("hostile text is refused, not obeyed") {
  // Depth and width that would overflow the parser's stack or the program's memory end in a ConfigError.
  std::string deep_arrays = "x = " + std::string(100'000, '[');
  std::string deep_tables = "x = ";
  for (int i = 0; i < 50'000; ++i) deep_tables += "{a=";
  std::string dotted = "a";
  for (int i = 0; i < 100'000; ++i) dotted += ".a";
  std::string many_headers;
  for (int i = 0; i < 20; ++i) many_headers += i == 0 ? "[t" : ".t";
  many_headers += "]\nx";
  for (int i = 0; i < 20; ++i) many_headers += ".x";
  const auto read = [](const Section& root) { root.number("x", 0); };
  CHECK(complaint(deep_arrays, read).starts_with("a.toml:1: not valid TOML"));
  CHECK(complaint(deep_tables, read).starts_with("a.toml:1: not valid TOML"));
  CHECK(complaint(dotted + " = 1", read) == "a.toml:1: a key with more than 32 dots");
  CHECK(complaint("[" + dotted + "]", read) == "a.toml:1: a key with more than 32 dots");
  CHECK(complaint(many_headers + " = 1", read) == "a.toml:2: tables nested more than 32 deep");
  CHECK(complaint("", read, {dotted + "=1"}).ends_with("tables nested more than 32 deep"));
  CHECK(complaint("x = \"\xff\xfe\"", read).starts_with("a.toml:1: not valid TOML"));
}
