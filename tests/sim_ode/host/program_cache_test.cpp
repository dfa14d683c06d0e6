// Controllers are compiled once. Most cases take a stand-in for the compiler, which preprocesses, counts its other
// starts and hands out an object that was made before.
#include "sim_ode/host/programs/program_cache.hpp"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <functional>

#include "sim_ode/host/programs/program_inputs.hpp"
#include "sim_ode/host/programs/robot_program.hpp"
#include "tests/support/processes/temporary_directory.hpp"

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

constexpr const char* still =
    "#include <kilolib.h>\nvoid nothing() {}\nint main() { kilo_init(); kilo_start(nothing, nothing); }\n";
const std::string with_part = "#include \"part.h\"\n" + std::string(still);

// A variable of the environment for as long as this lives.
class Environment {
 public:
  Environment(const char* name, const std::string& value) : name_(name) {
    if (const char* const before = std::getenv(name)) before_ = before;
    setenv(name, value.c_str(), 1);
  }
  ~Environment() { before_ ? setenv(name_, before_->c_str(), 1) : unsetenv(name_); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

// Compiled by the real compiler, once for all cases.
const fs::path& ready_object() {
  static const tests::TemporaryDirectory folder;
  static const ReadProgram program(folder.write("still.c", still));
  static const tests::TemporaryDirectory work;
  static ObjectBuild build(program, work.path());
  static const bool built = [] {
    build.run();
    return true;
  }();
  REQUIRE(built);
  return build.object();
}

// A user with an empty cache, a program and a compiler.
struct User {
  enum class Compiler { real, stand_in };
  explicit User(Compiler compiler = Compiler::stand_in) {
    program = folder.write("robot.c", with_part);
    folder.write("part.h", "");
    const std::string real = "PATH='" + usual_path + "' exec cc \"$@\"";
    std::string script = fmt::format("#!/bin/sh\ncase \"$*\" in *' -E '*) {} ;; esac\necho >> {}\n", real,
                                     (folder.path() / "starts").string());
    if (compiler == Compiler::real)
      script += real + "\n";
    else
      script += fmt::format(
          "while [ $# -gt 1 ]; do [ \"$1\" = -o ] && out=\"$2\"; shift; done\n"
          "case \"$out\" in *.so) cp {} \"$out\" ;; *) : > \"$out\" ;; esac\n",
          ready_object().string());
    compile_with(script);
  }
  void compile_with(const std::string& script) const { chmod(folder.write("bin/cc", script).c_str(), 0755); }
  // How often the compiler was started for this load.
  int starts_for_load() const {
    const auto before = starts();
    CHECK(RobotProgram::load(program)->memory_bytes() > 0);
    return static_cast<int>(starts() - before);
  }
  std::uintmax_t starts() const {
    std::error_code none;
    const auto bytes = fs::file_size(folder.path() / "starts", none);
    return none ? 0 : bytes;
  }
  fs::path kept() const {
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(cache, none)) return entry.path();
    return {};
  }
  long files() const {
    std::error_code none;
    return std::distance(fs::directory_iterator(cache, none), fs::directory_iterator());
  }

  tests::TemporaryDirectory folder;
  fs::path program, cache = folder.path() / "cache" / "arkmesh" / "controllers";
  Environment home{"XDG_CACHE_HOME", (folder.path() / "cache").string()};
  std::string usual_path = std::getenv("PATH");
  Environment path{"PATH", (folder.path() / "bin").string() + ":" + usual_path};
};

}  // namespace

TEST_CASE("a controller is compiled once, with the real compiler") {
  // The second load starts no compiler; a changed header, and one that comes to stand before the system's, is seen, and
  // what was there before needs none again.
  User user(User::Compiler::real);
  user.folder.write("robot.c", "#include \"part.h\"\n#include <ctype.h>\n" + std::string(still));
  CHECK(user.starts_for_load() > 0);
  CHECK(user.starts_for_load() == 0);
  user.folder.write("part.h", "static char more[1000] = {1};\nvoid* used() { return more; }\n");
  const auto before = user.starts();
  CHECK(RobotProgram::load(user.program)->memory_bytes() > 1000);
  CHECK(user.starts() > before);
  user.folder.write("ctype.h", "");
  CHECK(user.starts_for_load() > 0);
  fs::remove(user.folder.path() / "ctype.h");
  CHECK(user.starts_for_load() == 0);
}

TEST_CASE("a controller is compiled anew when anything that decides is new") {
  // One by one: the header, the program, its name, the compiler, a variable that the compiler reads.
  User user;
  CHECK(user.starts_for_load() > 0);
  CHECK(user.starts_for_load() == 0);
  user.folder.write("part.h", "int a;");
  CHECK(user.starts_for_load() > 0);
  user.folder.write("part.h", "");
  CHECK(user.starts_for_load() == 0);
  user.folder.write("robot.c", with_part + " ");
  CHECK(user.starts_for_load() > 0);
  user.program = user.folder.write("other.c", with_part);
  CHECK(user.starts_for_load() > 0);
  {
    const Environment more("LIBRARY_PATH", "/nowhere");
    CHECK(user.starts_for_load() > 0);
  }
  CHECK(user.starts_for_load() == 0);
  user.compile_with(tests::read_file(user.folder.path() / "bin" / "cc") + "# a newer one\n");
  CHECK(user.starts_for_load() > 0);
}

TEST_CASE("a program of the moment is not kept") {
  // __TIME__ and its like stand for the time of compiling, in the program and in its headers.
  User user;
  user.folder.write("part.h", "const char* built = __TIME__;");
  for (int i = 0; i < 2; ++i) CHECK(user.starts_for_load() > 0);
  user.folder.write("part.h", "");
  user.folder.write("robot.c", "// __DATE__\n" + with_part);
  for (int i = 0; i < 2; ++i) CHECK(user.starts_for_load() > 0);
  CHECK(user.files() == 0);
}

TEST_CASE("a damaged object is compiled anew and replaced") {
  // A byte is changed, then the file ends early, or is gone.
  User user;
  CHECK(user.starts_for_load() > 0);
  const fs::path object = user.kept();
  const auto damage = [&](const std::function<void()>& how) {
    how();
    CHECK(user.starts_for_load() > 0);
    CHECK(user.starts_for_load() == 0);
  };
  damage([&] { std::fstream(object, std::ios::in | std::ios::out | std::ios::binary).seekp(5000).write("???", 3); });
  damage([&] { fs::resize_file(object, 3000); });
  damage([&] { fs::resize_file(object, 0); });
  damage([&] { fs::remove(object); });
}

TEST_CASE("two processes may compile a program at once") {
  // Both load it, and what they leave is whole.
  User user;
  pid_t children[2];
  for (pid_t& child : children) {
    child = fork();
    REQUIRE(child >= 0);
    if (child > 0) continue;
    bool loaded = true;
    for (int i = 0; i < 5; ++i) {
      user.folder.write("part.h", fmt::format("// {}", i % 2));
      loaded = loaded && RobotProgram::load(user.program)->memory_bytes() > 0;
    }
    _exit(loaded ? 0 : 1);
  }
  for (const pid_t child : children) {
    int status = -1;
    waitpid(child, &status, 0);
    CHECK(status == 0);
  }
  user.starts_for_load();
  CHECK(user.starts_for_load() == 0);
}

TEST_CASE("programs run without a cache") {
  // No folder can be made; the disk is full; others can write there; it is switched off.
  User user;
  {
    const Environment nowhere("XDG_CACHE_HOME", "/dev/null");
    for (int i = 0; i < 2; ++i) CHECK(user.starts_for_load() > 0);
  }
  {
    const Environment off("ARKMESH_CACHE", "off");
    CHECK(user.starts_for_load() > 0);
    CHECK(user.files() == 0);
  }
  {
    const ReadProgram read(user.program);
    const tests::TemporaryDirectory work;
    ObjectBuild build(read, work.path());
    const ProgramCache cache(user.cache, build);
    build.run();
    rlimit usual{};
    getrlimit(RLIMIT_FSIZE, &usual);
    const rlimit little{1000, usual.rlim_max};
    std::signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &little);
    cache.keep();
    setrlimit(RLIMIT_FSIZE, &usual);
    std::signal(SIGXFSZ, SIG_DFL);
    CHECK(user.files() == 0);
    CHECK_FALSE(cache.find());
    cache.keep();
    CHECK(cache.find());
  }
  CHECK(user.starts_for_load() == 0);
  chmod(user.cache.c_str(), 0777);
  CHECK(user.starts_for_load() > 0);
  const Environment wrong("ARKMESH_CACHE", "maybe");
  CHECK_THROWS_WITH_AS(RobotProgram::load(user.program),
                       "the environment's ARKMESH_CACHE is \"maybe\"; it can be off, or not be set", ProgramError);
}

TEST_CASE("the cache has a bound") {
  // What was not used for the longest time leaves first, and what a killed process left aside leaves, too.
  User user;
  CHECK(user.starts_for_load() > 0);
  const fs::path old = user.kept();
  const auto long_ago = fs::file_time_type::clock::now() - std::chrono::hours(2);
  fs::last_write_time(old, long_ago);
  const fs::path aside = user.cache / "a.so.XyZ123";
  std::ofstream(aside) << "half";
  fs::last_write_time(aside, long_ago);

  const fs::path other = user.folder.write("other.c", still);
  const ReadProgram read(other);
  const tests::TemporaryDirectory work;
  ObjectBuild build(read, work.path());
  const ProgramCache cache(user.cache, build);
  build.run();
  cache.keep(fs::file_size(old) * 3 / 2);
  CHECK_FALSE(fs::exists(old));
  CHECK_FALSE(fs::exists(aside));
  CHECK(cache.find());
  cache.keep(1);
  CHECK(user.files() == 0);
}

TEST_CASE("a compiler that never ends is ended") {
  // With what it has started, and the sentence names it.
  const User user;
  user.compile_with(fmt::format("#!/bin/sh\nsleep 600 &\necho $! > {}/child\nwait\n", user.folder.path().string()));
  const ReadProgram read(user.program);
  const tests::TemporaryDirectory work;
  ObjectBuild build(read, work.path(), {.time = std::chrono::milliseconds(300)});
  CHECK_THROWS_WITH_AS(
      build.run(),
      "does not compile: the C compiler `cc` was ended because it had not finished after 60 s of work, "
      "or 0.3 s in all",
      ProgramError);
  const std::string child = tests::read_file(user.folder.path() / "child");
  REQUIRE(!child.empty());
  // gone, or waiting for somebody to ask for its end
  CHECK(tests::eventually(std::chrono::seconds(300), [&] {
    const std::string state = tests::read_file(fmt::format("/proc/{}/stat", std::stoi(child)));
    return state.empty() || state.find(") Z") != std::string::npos;
  }));
}

TEST_CASE("a compiler that works for too long is ended") {
  // That of this machine is, and one that works by itself.
  User user;
  std::string program = still;
  for (int i = 0; i < 7; ++i)
    program += fmt::format("#define M{} M{} + M{} + M{} + M{} + M{} + M{} + M{} + M{} + M{} + M{}\n", i + 1, i, i, i, i,
                           i, i, i, i, i, i);
  program += "int M0 = 1; int sum() { return M7; }\n";
  const tests::TemporaryDirectory work;
  const ReadProgram read(user.folder.write("long.c", program));
  const auto seconds_of_work = [&] { ObjectBuild(read, work.path(), {.work = std::chrono::seconds(1)}).run(); };
  const char* sentence =
      "does not compile: the C compiler `cc` was ended because it had not finished after 1 s of work, or 600 s in all";
  CHECK_THROWS_WITH_AS(seconds_of_work(), sentence, ProgramError);
  user.compile_with("#!/bin/sh\nwhile :; do :; done\n");
  CHECK_THROWS_WITH_AS(seconds_of_work(), sentence, ProgramError);
}

TEST_CASE("what decides a program is read from rules and sources") {
  // Names with blanks, hashes and dollars; includes of both kinds and those that are only asked for.
  CHECK(paths_in_rules("a.o: /x/a\\ b.h /x/c\\#d.h \\\n /x/e$$f.h\nb.o: /y.h\n") ==
        std::vector<std::string>{"/x/a b.h", "/x/c#d.h", "/x/e$f.h", "/y.h"});
  CHECK(names_included("#include <a.h>\n# include \"b/c.h\"\n#include_next <d.h>\n"
                       "#if __has_include(\"e.h\")\n#include MACRO\n#include \"open\n") ==
        std::vector<std::string>{"a.h", "b/c.h", "d.h", "e.h"});
}

}  // namespace arkmesh::sim_ode
