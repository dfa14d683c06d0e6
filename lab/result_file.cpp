#include "lab/result_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

namespace arkmesh::lab {

namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t largest_result_bytes = 16 << 20;

std::string host_name() {
  std::array<char, 256> name{};
  ::gethostname(name.data(), name.size() - 1);
  return name.data();
}

bool is_running(const nlohmann::json& result) {
  return result.is_object() && result.contains("state") && result["state"] == "running" && result.contains("process");
}

// When the process began, in clock ticks since this machine did; 0 when there is no such process. Ids are used again,
// after the machine's next start too. Source: proc(5), field 22 of stat; field 2 ends with the last ')'.
std::int64_t began(std::int64_t process) {
  std::ifstream file(fmt::format("/proc/{}/stat", process));
  const std::string stat{std::istreambuf_iterator<char>(file), {}};
  const auto name_end = stat.rfind(')');
  if (name_end == std::string::npos) return 0;
  std::istringstream fields(stat.substr(name_end + 1));
  std::string field;
  for (int i = 3; i <= 22; ++i) fields >> field;
  std::int64_t ticks = 0;
  std::from_chars(field.data(), field.data() + field.size(), ticks);
  return ticks;
}

// Of another machine it cannot be known.
bool lives(const nlohmann::json& result) {
  const nlohmann::json& process = result.at("process");
  return process.value("host", "") != host_name() ||
         began(process.value("pid", 0)) == process.value("began_ticks", std::int64_t{-1});
}

// Null for what is no result: beside a run there may be anything.
nlohmann::json read(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error) || fs::file_size(file, error) > largest_result_bytes) return {};
  std::ifstream in(file);
  return in ? nlohmann::json::parse(in, nullptr, false) : nlohmann::json();
}

// Returns the labs of a run whose folder this is.
std::vector<std::string> mark_killed(const fs::path& directory) {
  nlohmann::json result = read(directory / "result.json");
  if (!is_running(result) || lives(result)) return {};
  result["state"] = "killed";
  result["ended"] = fmt::format("killed: process {} is gone and left no result", result["process"].value("pid", 0));
  replace_json(directory / "result.json", result);
  return result.value("labs", std::vector<std::string>());
}

}  // namespace

int replace_json(const fs::path& file, const nlohmann::json& json) {
  const std::string text = json.dump(2) + "\n";
  const fs::path written = file.string() + ".new";
  const int descriptor = ::open(written.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor < 0) return errno;
  int error = 0;
  for (std::size_t done = 0; done < text.size() && error == 0;) {
    const ssize_t n = ::write(descriptor, text.data() + done, text.size() - done);
    if (n >= 0)
      done += static_cast<std::size_t>(n);
    else if (errno != EINTR)
      error = errno;
  }
  if (error == 0 && ::fsync(descriptor) != 0) error = errno;
  ::close(descriptor);
  if (error == 0 && ::rename(written.c_str(), file.c_str()) != 0) error = errno;
  if (error != 0) ::unlink(written.c_str());
  return error;
}

void save_running(const fs::path& file, nlohmann::json facts) {
  facts["state"] = facts["ended"] = "running";
  replace_json(file, facts);
}

void save_json(const fs::path& file, const nlohmann::json& json) {
  const int error = replace_json(file, json);
  if (error == 0) return;
  spdlog::warn("{} cannot be written ({}); it is printed instead", file.string(), std::strerror(error));
  std::puts(json.dump(2).c_str());
}

nlohmann::json own_process() {
  return {{"pid", ::getpid()}, {"began_ticks", began(::getpid())}, {"host", host_name()}};
}

std::string running_in(const fs::path& directory) {
  const nlohmann::json result = read(directory / "result.json");
  if (!is_running(result) || !lives(result)) return {};
  return fmt::format("the run of {} (process {}), which still goes on",
                     fmt::join(result.value("labs", std::vector<std::string>()), ", "),
                     result["process"].value("pid", 0));
}

void mark_killed_beside(const fs::path& directory) {
  std::error_code error;
  for (fs::directory_iterator entry(directory.parent_path(), error), end; !error && entry != end;
       entry.increment(error))
    try {
      if (std::error_code unknown; entry->is_directory(unknown))
        for (const std::string& lab : mark_killed(entry->path())) mark_killed(entry->path() / lab);
    } catch (const nlohmann::json::exception&) {
      // somebody else's result.json
    }
}

}  // namespace arkmesh::lab
