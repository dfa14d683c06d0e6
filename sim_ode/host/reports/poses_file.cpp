#include "sim_ode/host/reports/poses_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "hal/overlay/led_name.hpp"

namespace arkmesh::sim_ode {

namespace fs = std::filesystem;

PosesFile::PosesFile(const std::string& name, std::vector<std::string> objects)
    : path_(name), objects_(std::move(objects)), temporary_(name.empty()) {
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
  for (std::size_t i = 0; i < std::min(objects_.size(), frame.objects.size()); ++i) {
    const hal::Pose& pose = frame.objects[i].pose;
    out_ << fmt::format("{:.1f},{},{:.6f},{:.6f},{:.4f},\n", time_s, objects_[i], pose.x_m, pose.y_m, pose.heading_rad);
  }
}

const fs::path& PosesFile::finished() {
  out_.close();
  if (!out_)
    throw std::runtime_error(fmt::format("{} could not be written to the end; is the disk full?", path_.string()));
  return path_;
}

}  // namespace arkmesh::sim_ode
