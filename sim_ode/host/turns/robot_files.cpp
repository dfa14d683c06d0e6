#include "sim_ode/host/turns/robot_files.hpp"

#include <fstream>
#include <system_error>

namespace arkmesh::sim_ode {

namespace fs = std::filesystem;

RobotFiles::~RobotFiles() {
  for (std::FILE* file : open_) std::fclose(file);
  for (std::size_t robot = 0; robot < printed_.size(); ++robot) write(static_cast<int>(robot));
}

std::FILE* RobotFiles::open(int robot, const std::string& name, const std::string& mode) {
  if (folder_.empty()) return nullptr;
  fs::path inside = fs::path(name).relative_path().lexically_normal();
  if (inside.begin() != inside.end() && *inside.begin() == "..") inside = inside.filename();
  const fs::path own = folder_of(robot) / inside;
  std::error_code error;
  if (mode.find_first_of("wa") != std::string::npos) fs::create_directories(own.parent_path(), error);
  std::FILE* file = std::fopen(own.c_str(), mode.c_str());
  if (!file && mode.starts_with("r") && mode.find('+') == std::string::npos)
    file = std::fopen(name.c_str(), mode.c_str());
  if (file) open_.insert(file);
  return file;
}

int RobotFiles::close(std::FILE* file) {
  open_.erase(file);
  return std::fclose(file);
}

void RobotFiles::print(int robot, std::string_view text) {
  if (folder_.empty()) return;
  Printed& printed = printed_[static_cast<std::size_t>(robot)];
  if (printed.written + printed.text.size() > most_printed) return;
  printed.text += text;
  if (printed.written + printed.text.size() > most_printed) printed.text += "\n(no more of it is kept)\n";
  if (printed.text.size() >= buffered) write(robot);
}

void RobotFiles::write(int robot) {
  Printed& printed = printed_[static_cast<std::size_t>(robot)];
  if (printed.text.empty()) return;
  std::error_code error;
  fs::create_directories(folder_of(robot), error);
  std::ofstream(folder_of(robot) / "printed.txt", printed.written > 0 ? std::ios::app : std::ios::trunc)
      << printed.text;
  printed.written += printed.text.size();
  printed.text.clear();
}

}  // namespace arkmesh::sim_ode
