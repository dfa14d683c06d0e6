#include "app/doctor/device_files.hpp"

#include <fmt/format.h>
#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <string>

namespace arkmesh::app {
namespace {

namespace fs = std::filesystem;
using hal::Finding;

// Devices of /dev whose names begin like one of these, in order.
std::vector<fs::path> devices(std::initializer_list<const char*> beginnings) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator it("/dev", error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (std::any_of(beginnings.begin(), beginnings.end(),
                    [&](const char* beginning) { return name.starts_with(beginning); }))
      found.push_back(it->path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

Finding usable(const std::string& kind, const fs::path& device) {
  Finding finding{fmt::format("{} {}", kind, device.string()), "", ""};
  if (::access(device.c_str(), R_OK | W_OK) == 0) return finding;
  struct stat about {};
  const ::group* owner = ::stat(device.c_str(), &about) == 0 ? ::getgrgid(about.st_gid) : nullptr;
  const std::string group = owner ? owner->gr_name : "that it belongs to";
  finding.problem = fmt::format("no permission: you are not in the group {}", group);
  finding.remedy = fmt::format("sudo usermod -aG {} $USER, then log in again", group);
  return finding;
}

std::vector<Finding> all_usable(const std::string& kind, const std::vector<fs::path>& found) {
  if (found.empty()) return {{fmt::format("{}: none on this machine", kind), "", ""}};
  std::vector<Finding> findings;
  for (const fs::path& device : found) findings.push_back(usable(kind, device));
  return findings;
}

}  // namespace

std::vector<Finding> serial_ports() {
  return all_usable("USB serial port", devices({"ttyUSB", "ttyACM"}));
}

std::vector<Finding> cameras() {
  return all_usable("camera", devices({"video"}));
}

}  // namespace arkmesh::app
