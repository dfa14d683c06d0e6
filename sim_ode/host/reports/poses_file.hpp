// Where each robot of a swarm was, as a CSV file: a row per robot and frame. Objects that robots push follow, by name.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "hal/types.hpp"

namespace arkmesh::sim_ode {

class PosesFile {
 public:
  // Empty `name`: a temporary file, removed at the end. Throws std::runtime_error when it cannot be written.
  // `objects`: names, in the order of PoseFrame::objects.
  explicit PosesFile(const std::string& name, std::vector<std::string> objects = {});
  ~PosesFile();
  PosesFile(const PosesFile&) = delete;
  PosesFile& operator=(const PosesFile&) = delete;

  void write(const hal::PoseFrame& frame);
  // All of it is in the file, or the disk is full, which throws std::runtime_error.
  const std::filesystem::path& finished();

 private:
  std::filesystem::path path_;
  std::vector<std::string> objects_;
  bool temporary_;
  std::ofstream out_;
};

}  // namespace arkmesh::sim_ode
