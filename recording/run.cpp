#include "recording/run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <limits>
#include <map>
#include <stdexcept>

#include "hal/config.hpp"
#include "recording/message.hpp"
#include "recording/whole_file.hpp"

namespace arkmesh::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_labs = 64;
constexpr std::uintmax_t max_result_bytes = 16 << 20;

nlohmann::json json_of(const fs::path& file) {
  const auto text = whole_file(file, max_result_bytes);
  return text ? nlohmann::json::parse(*text, nullptr, false) : nlohmann::json();
}

std::string text_of(const nlohmann::json& object, const char* key) {
  const auto found = object.is_object() ? object.find(key) : object.end();
  return object.is_object() && found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

// Links that lead in circles and what may not be looked at are none. `error` is of the folder itself.
std::vector<fs::path> folders_in(const fs::path& folder, std::error_code& error) {
  std::vector<fs::path> out;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (std::error_code unknown; entry->is_directory(unknown)) out.push_back(entry->path());
  std::ranges::sort(out);
  return out;
}

std::vector<fs::path> folders_in(const fs::path& folder) {
  std::error_code error;
  return folders_in(folder, error);
}

bool has_log(const fs::path& folder) {
  std::error_code error;
  return fs::is_regular_file(folder / "log.lcm", error);
}

// Why it cannot be known whether there is a log: "Permission denied"; empty: it can.
std::string hidden(const fs::path& folder) {
  std::error_code error;
  const bool is_unknown = fs::status(folder / "log.lcm", error).type() == fs::file_type::none;
  return is_unknown ? error.message() : std::string();
}

// The configurations of a run that has no log, or of the first such run of a batch, as a shell names them.
std::string configs_without_log(const fs::path& folder) {
  for (const fs::path& run : {folder, folder / "runs" / "00000"})
    for (const fs::path& below : folders_in(run))
      if (std::error_code error; fs::is_regular_file(below / "config.toml", error))
        return (run / "*" / "config.toml").string();
  std::error_code error;
  return fs::is_regular_file(folder / "config.toml", error) ? (folder / "config.toml").string() : std::string();
}

// Whether the process that a result.json calls running still writes to the log.
bool is_written(const RecordedLab& lab) {
  const nlohmann::json result = json_of(lab.folder / "result.json");
  if (text_of(result, "state") != "running") return false;
  char host[256] = {};
  ::gethostname(host, sizeof host - 1);
  const auto process = result.find("process");
  if (process != result.end() && text_of(*process, "host") == host) {
    const auto pid = process->find("pid");
    if (pid != process->end() && pid->is_number_integer() && pid->get<std::int64_t>() > 1 &&
        pid->get<std::int64_t>() <= std::numeric_limits<pid_t>::max())
      return ::kill(static_cast<pid_t>(pid->get<std::int64_t>()), 0) == 0 || errno == EPERM;
  }
  std::error_code error;
  const auto written = fs::last_write_time(lab.log->file(), error);
  return !error && fs::file_time_type::clock::now() - written < std::chrono::minutes(1);
}

}  // namespace

bool is_run(const fs::path& folder) {
  return has_log(folder) || std::ranges::any_of(folders_in(folder), has_log);
}

Run::Run(const fs::path& folder) : folder_(fs::absolute(folder / "").lexically_normal().parent_path()) {
  std::error_code error;
  if (!fs::is_directory(folder_, error))
    throw hal::ConfigError(fmt::format("{} is no folder; give that of a run", folder.string()));
  std::vector<fs::path> folders;
  if (has_log(folder_)) {
    folders = {folder_};
  } else {
    for (const fs::path& below : folders_in(folder_, error)) {
      if (has_log(below)) folders.push_back(below);
      if (const std::string why = hidden(below); !why.empty())
        left_out_.push_back(fmt::format("{} cannot be read: {}; what it holds is left out", below.string(), why));
    }
    if (error) throw hal::ConfigError(fmt::format("{} cannot be read: {}", folder.string(), error.message()));
    if (folders.empty() && !left_out_.empty()) throw hal::ConfigError(left_out_.front());
  }
  if (folders.empty()) {
    const auto runs = runs_of_batch(folder_);
    if (!runs.empty())
      throw hal::ConfigError(fmt::format("{} holds the {} runs of a batch; give one of them, as {}", folder.string(),
                                         runs.size(), (folder / runs.front().lexically_relative(folder_)).string()));
    if (const std::string configs = configs_without_log(folder_); !configs.empty())
      throw hal::ConfigError(
          fmt::format("{} has no message log (recorder.log = false, as in batches); arkmesh run {} --set "
                      "recorder.log=true --out FOLDER does the run again with one",
                      folder.string(), configs));
    throw hal::ConfigError(
        fmt::format("{} is no run folder: there is no log.lcm in it or one level below", folder.string()));
  }
  if (folders.size() > max_labs)
    throw hal::ConfigError(
        fmt::format("{} holds {} logs, and a run has {} labs at most", folder.string(), folders.size(), max_labs));
  for (const fs::path& each : folders) {
    RecordedLab lab;
    lab.folder = each;
    lab.result = json_of(each / "result.json");
    lab.name = text_of(lab.result, "lab");
    if (lab.name.empty() || lab.name.find('/') != std::string::npos) lab.name = each.filename().string();
    lab.log = std::make_unique<Log>(each / "log.lcm");
    labs_.push_back(std::move(lab));
  }
  // runs of one lab that somebody has laid side by side
  std::map<std::string, int> times;
  for (const RecordedLab& lab : labs_) ++times[lab.name];
  for (RecordedLab& lab : labs_)
    if (times[lab.name] > 1) lab.name = lab.folder.filename().string();
  std::ranges::sort(labs_, {}, &RecordedLab::name);
}

std::string Run::name() const {
  return folder_.filename().string();
}

std::int64_t Run::length_us() const {
  std::int64_t out = 0;
  for (const RecordedLab& lab : labs_) out = std::max(out, lab.log->length_us());
  return out;
}

bool Run::is_growing() const {
  return std::ranges::any_of(labs_, is_written);
}

bool Run::refresh() {
  bool is_new = false;
  for (const RecordedLab& lab : labs_) is_new = lab.log->refresh() || is_new;
  return is_new;
}

std::vector<std::string> Run::notes() const {
  std::vector<std::string> out = left_out_;
  for (const RecordedLab& lab : labs_) {
    const Log& log = *lab.log;
    if (log.entries().empty()) out.push_back(fmt::format("{} holds no whole message", log.file().string()));
    if (log.unread_bytes() > 0 && !is_written(lab))
      out.push_back(fmt::format("{} is cut or damaged: its last {} bytes are left out, and it is used up to {:.3f} s",
                                log.file().string(), log.unread_bytes(), static_cast<double>(log.length_us()) / 1e6));
    if (log.moved() > 0)
      out.push_back(fmt::format(
          "{} has {} messages with a time before that of the message ahead of them; they stand at that time",
          log.file().string(), log.moved()));
    std::vector<std::string> strange;
    for (std::size_t i = 0; i < log.channels().size(); ++i) {
      const auto message = log.read(log.entries()[log.of_channel(i).front()]);
      if (types().of_channel(log.channels()[i]) && !type_of(message, types())) strange.push_back(log.channels()[i]);
    }
    if (strange.empty()) continue;
    const std::string version = text_of(lab.result, "arkmesh");
    out.push_back(fmt::format(
        "{} is of another version of arkmesh{}: its messages on {} are left out, for this is {} and has other types",
        log.file().string(), version.empty() ? "" : fmt::format(" ({})", version), fmt::join(strange, ", "),
        ARKMESH_VERSION));
  }
  return out;
}

std::vector<fs::path> runs_of_batch(const fs::path& folder) {
  std::vector<fs::path> out;
  for (const fs::path& below : folders_in(folder / "runs"))
    if (is_run(below)) out.push_back(below);
  if (!out.empty()) return out;
  // seeds by number, so that seed-10 follows seed-9
  std::vector<std::pair<unsigned long, fs::path>> seeds;
  for (const fs::path& below : folders_in(folder)) {
    const std::string name = below.filename().string();
    unsigned long seed = 0;
    if (!name.starts_with("seed-")) continue;
    const auto [end, error] = std::from_chars(name.data() + 5, name.data() + name.size(), seed);
    if (error == std::errc() && end == name.data() + name.size() && is_run(below)) seeds.emplace_back(seed, below);
  }
  std::ranges::sort(seeds);
  for (auto& [seed, path] : seeds) out.push_back(std::move(path));
  return out;
}

}  // namespace arkmesh::recording
