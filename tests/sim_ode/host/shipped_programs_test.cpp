// Programs that an installation has compiled are found by what they say, wherever they lie.
#include "sim_ode/host/programs/shipped_programs.hpp"

#include <doctest/doctest.h>

#include "tests/support/processes/temporary_directory.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr const char* shipped_text =
    "#include <kilolib.h>\n#include \"name.h\"\nvoid nothing() {}\n"
    "int main() { kilo_init(); kilo_start(nothing, nothing); }\n";

TEST_CASE("a shipped program is found in every folder by its texts, headers and macros, and by nothing less") {
  const tests::TemporaryDirectory first, copy, shipped;
  first.write("name.h", "#define NAME 1\n");
  const ReadProgram program(first.write("still.c", shipped_text));
  CHECK_FALSE(find_shipped(program, shipped.path() / "none"));
  ship_program(program, shipped.path());
  REQUIRE(find_shipped(program, shipped.path()));

  copy.write("name.h", "#define NAME 1\n");
  ProgramSources same = copy.write("other.c", shipped_text);
  CHECK(find_shipped(ReadProgram(same), shipped.path()) == find_shipped(program, shipped.path()));
  same.define = {"NAME=1"};
  CHECK_FALSE(find_shipped(ReadProgram(same), shipped.path()));
  same.define.clear();
  copy.write("name.h", "#define NAME 2\n");
  CHECK_FALSE(find_shipped(ReadProgram(same), shipped.path()));
  copy.write("name.h", "#define NAME 1\n");
  copy.write("more.h", "");
  CHECK_FALSE(find_shipped(ReadProgram(same), shipped.path()));
  CHECK_FALSE(find_shipped(ReadProgram(copy.write("other.c", std::string(shipped_text) + "\n")), shipped.path()));
}

}  // namespace
}  // namespace arkmesh::sim_ode
