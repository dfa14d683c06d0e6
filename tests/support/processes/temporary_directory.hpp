// A temporary folder that tests fill with files.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "tests/support/processes/process.hpp"

namespace arkmesh::tests {

class TemporaryDirectory : public TemporaryFolder {
 public:
  // Writes a file below the folder, making the folders in between, and returns its path.
  std::filesystem::path write(const std::string& name, std::string_view text) const {
    const std::filesystem::path file = path() / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary).write(text.data(), static_cast<std::streamsize>(text.size()));
    return file;
  }
};

}  // namespace arkmesh::tests
