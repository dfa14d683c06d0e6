#include "hal/scratch_folder.hpp"

#include <fmt/format.h>
#include <stdlib.h>

#include <stdexcept>

namespace arkmesh::hal {

namespace fs = std::filesystem;

ScratchFolder::ScratchFolder(const std::string& name) {
  std::error_code error;
  fs::path base = fs::temp_directory_path(error);
  if (error) base = "/tmp";
  std::string made = (base / ("arkmesh-" + name + "-XXXXXX")).string();
  if (!::mkdtemp(made.data()))
    throw std::runtime_error(
        fmt::format("no directory can be made in {}; free some space or set TMPDIR", base.string()));
  path_ = made;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace arkmesh::hal
