#include "hal/files/scratch_folder.hpp"

#include <doctest/doctest.h>

#include <fstream>

using arkmesh::hal::ScratchFolder;
namespace fs = std::filesystem;

TEST_CASE("a scratch folder is one's own, and gone with its owner") {
  fs::path path;
  {
    const ScratchFolder folder("test"), other("test");
    path = folder.path();
    CHECK(path != other.path());
    CHECK(path.filename().string().starts_with("arkmesh-test-"));
    REQUIRE(fs::is_directory(path));
    fs::create_directory(path / "below");
    CHECK(std::ofstream(path / "below" / "file"));
  }
  CHECK_FALSE(fs::exists(path));
}
