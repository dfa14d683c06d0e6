// Files that are replaced as a whole.
#include "hal/files/replace_file.hpp"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <cerrno>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "hal/config/guarded_file.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;

namespace {

std::string content(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

mode_t rights(const std::filesystem::path& file) {
  struct stat about {};
  REQUIRE(::stat(file.c_str(), &about) == 0);
  return about.st_mode & 07777;
}

}  // namespace

TEST_CASE("what is replaced is never half written") {
  // Proves the new content and nothing beside it, what a killed process left, and the old content after each error.
  const tests::TemporaryDirectory root;
  const auto file = root.path() / "result.json";
  CHECK(hal::replace_file(file, "1") == 0);
  std::ofstream(hal::part_of(file)) << "of a killed process that was long";
  CHECK(hal::replace_file(file, "22") == 0);
  CHECK(content(file) == "22");
  CHECK(std::distance(std::filesystem::directory_iterator(root.path()), {}) == 1);
  CHECK(hal::replace_file(root.path() / "nowhere" / "result.json", "3") == ENOENT);
  std::filesystem::create_directory(hal::part_of(file));  // in the way
  CHECK(hal::replace_file(file, "4") != 0);
  CHECK_THROWS_WITH_AS(hal::must_replace_file(file, "4"), (file.string() + " cannot be written: File exists").c_str(),
                       std::runtime_error);
  CHECK(content(file) == "22");
  CHECK(hal::put_in_place(root.path() / "nothing", file) == ENOENT);
}

TEST_CASE("a replaced file has the rights that are asked for, and no link is followed") {
  // Proves exact rights whatever the umask is and the old file had, and that a link in the way is not followed.
  const tests::TemporaryDirectory root;
  const auto file = root.path() / "key.pem", other = root.path() / "other";
  std::ofstream(file) << "open to all";
  std::ofstream(other) << "of somebody else";
  std::filesystem::create_symlink(other, hal::part_of(file));
  const mode_t before = ::umask(0177);
  hal::write_guarded(file, "secret", hal::secret_mode);
  CHECK(rights(file) == 0600);
  hal::write_guarded(root.path() / "certificate.pem", "public", hal::readable_mode);
  CHECK(rights(root.path() / "certificate.pem") == 0644);
  CHECK(hal::replace_file(root.path() / "table.csv", "a,b") == 0);
  CHECK(rights(root.path() / "table.csv") == 0600);
  ::umask(before);
  CHECK(content(other) == "of somebody else");
  CHECK(content(file) == "secret");
}
