#include "sim_ode/host/poses_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <stdexcept>

#include "hal/led_name.hpp"

namespace arkmesh::sim_ode {

namespace fs = std::filesystem;

PosesFile::PosesFile(const std::string& name) : path_(name), temporary_(name.empty()) {
  if (temporary_) path_ = fs::temp_directory_path() / fmt::format("arkmesh-poses-{}.csv", getpid());
  out_.open(path_, std::ios::binary);
  out_ << "time_s,robot,x_m,y_m,heading_rad,led\n";
  if (!out_) throw std::runtime_error(fmt::format("{} cannot be written", path_.string()));
}

PosesFile::~PosesFile() {
  std::error_code ignored;
  if (temporary_) fs::remove(path_, ignored);
}

void PosesFile::write(const hal::PoseFrame& frame) {
  const double time_s = static_cast<double>(frame.stamp.count()) * 1e-6;
  for (const hal::Observation& robot : frame.robots)
    out_ << fmt::format("{:.1f},{},{:.6f},{:.6f},{:.4f},{}\n", time_s, robot.robot, robot.pose.x_m, robot.pose.y_m,
                        robot.pose.heading_rad, hal::name_of(robot.led));
}

const fs::path& PosesFile::finished() {
  out_.close();
  if (!out_)
    throw std::runtime_error(fmt::format("{} could not be written to the end; is the disk full?", path_.string()));
  return path_;
}

}  // namespace arkmesh::sim_ode
