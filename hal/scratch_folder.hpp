// A folder of our own below the system's temporary one; removed with everything in it.
#pragma once

#include <filesystem>
#include <string>

namespace arkmesh::hal {

class ScratchFolder {
 public:
  // `name` tells people whose it is: arkmesh-NAME-XXXXXX. Throws std::runtime_error when no folder can be made.
  explicit ScratchFolder(const std::string& name);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace arkmesh::hal
