// One table of exit codes: the page says what the header does.
#include "hal/exit_code.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "tests/support/processes/process.hpp"

using namespace arkmesh;

TEST_CASE("exit codes: docs/formats.md has each row of the table, and no other") {
  const std::string page = tests::read_file(std::string(ARKMESH_SOURCE_DIR) + "/docs/formats.md");
  const std::size_t begin = page.find("## Exit codes");
  REQUIRE(begin != std::string::npos);
  const std::string section = page.substr(begin, page.find("\n## ", begin + 1) - begin);
  for (const hal::ExitCodeRow& row : hal::exit_codes)
    CHECK(section.find(fmt::format("| {} | {}", row.code, row.meaning)) != std::string::npos);
  CHECK(section.find(fmt::format("| {} |", std::size(hal::exit_codes))) == std::string::npos);
}
