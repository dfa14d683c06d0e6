// A folder of our own below the system's temporary one; removed with everything in it, also when
// this process is killed.
#pragma once

#include <cstdio>
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
  std::FILE* keeper_ = nullptr;  // a process that removes the folder when this one has ended
};

}  // namespace arkmesh::hal
