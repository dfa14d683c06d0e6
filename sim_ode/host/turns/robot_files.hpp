// Files that robots' programs open, and what they print: in a folder of each robot's own. Closes what they leave open.
#pragma once

#include <cstdio>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace arkmesh::sim_ode {

class RobotFiles {
 public:
  // `folder` is made when it is needed; empty: robots have no files, and what they print is not kept.
  explicit RobotFiles(std::filesystem::path folder, std::vector<std::string> names)
      : folder_(std::move(folder)), names_(std::move(names)), printed_(names_.size()) {}
  ~RobotFiles();
  RobotFiles(const RobotFiles&) = delete;
  RobotFiles& operator=(const RobotFiles&) = delete;

  // As fopen(): a file of that name in the robot's folder. What is only read may lie elsewhere.
  std::FILE* open(int robot, const std::string& name, const std::string& mode);
  bool has(std::FILE* file) const { return open_.contains(file); }
  int close(std::FILE* file);  // as fclose(), of one that it has

  void print(int robot, std::string_view text);

 private:
  // Of a robot's printed.txt, and before it is written.
  static constexpr std::size_t most_printed = 1 << 20, buffered = 4096;
  struct Printed {
    std::string text;
    std::size_t written = 0;
  };
  std::filesystem::path folder_of(int robot) const { return folder_ / names_[static_cast<std::size_t>(robot)]; }
  void write(int robot);

  const std::filesystem::path folder_;
  const std::vector<std::string> names_;  // of robots' folders
  std::vector<Printed> printed_;
  std::set<std::FILE*> open_;
};

}  // namespace arkmesh::sim_ode
