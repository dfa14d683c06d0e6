#include "hal/files/scratch_folder.hpp"

#include <fmt/format.h>
#include <stdio.h>
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
  // Reads until this process ends, however it does; "e": no child of ours holds it open. A compiler may write for a
  // while yet.
  if (made.find('\'') == std::string::npos)
    keeper_ = ::popen(fmt::format("trap '' INT TERM HUP QUIT; read _; for _ in 1 2 3 4 5; do rm -rf -- '{}' && exit; "
                                  "sleep 1; done",
                                  made)
                          .c_str(),
                      "we");
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  if (keeper_) ::pclose(keeper_);
}

}  // namespace arkmesh::hal
