#include "hal/files/whole_file.hpp"

#include <fstream>
#include <sstream>
#include <utility>

namespace arkmesh::hal {

std::optional<std::string> whole_file(const std::filesystem::path& file, std::uintmax_t max_bytes) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error) || std::filesystem::file_size(file, error) > max_bytes || error)
    return {};
  std::ifstream in(file, std::ios::binary);
  if (!in) return {};
  std::ostringstream out;
  out << in.rdbuf();
  return std::move(out).str();
}

}  // namespace arkmesh::hal
