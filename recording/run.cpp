#include "recording/run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <stdexcept>

#include "hal/config/config.hpp"
#include "hal/counted.hpp"
#include "hal/layout/message.hpp"
#include "hal/record/event_log.hpp"
#include "hal/record/result_file.hpp"

namespace arkmesh::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_labs = 64;
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
  return fs::is_regular_file(hal::log_in(folder), error);
}

// Why it cannot be known whether there is a log: "Permission denied"; empty: it can.
std::string hidden(const fs::path& folder) {
  std::error_code error;
  const bool is_unknown = fs::status(hal::log_in(folder), error).type() == fs::file_type::none;
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

// Whether the lab still writes to the log. Of a run on another machine only the file's age tells.
bool is_written(const RecordedLab& lab) {
  using Runs = hal::ResultFile::Runs;
  const Runs runs = hal::ResultFile(lab.folder).runs();
  if (runs != Runs::unknown) return runs == Runs::yes;
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
    throw hal::ConfigError(fmt::format("{} is not a folder; give that of a run", folder.string()));
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
      throw hal::ConfigError(fmt::format("{} holds {} of a batch; give one, as {}", folder.string(),
                                         hal::counted(runs.size(), "run"),
                                         (folder / runs.front().lexically_relative(folder_)).string()));
    if (const std::string configs = configs_without_log(folder_); !configs.empty())
      throw hal::ConfigError(
          fmt::format("{} has no message log (recorder.log = false, as in batches); arkmesh run {} --set "
                      "recorder.log=true --out FOLDER repeats the run with one",
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
    const hal::ResultFile result(each);
    lab.version = result.text("arkmesh");
    lab.name = result.text("lab");
    if (lab.name.empty() || lab.name.find('/') != std::string::npos) lab.name = each.filename().string();
    lab.log = std::make_unique<Log>(hal::log_in(each));
    labs_.push_back(std::move(lab));
  }
  for (const std::string& name : hal::ResultFile(folder_).labs())
    if (!has_log(folder_) && std::ranges::find(labs_, name, &RecordedLab::name) == labs_.end())
      left_out_.push_back(
          fmt::format("{} has no log of lab {}, which took part; the lab is left out", folder.string(), name));
  // runs of one lab that somebody has laid side by side
  std::map<std::string, int> times;
  for (const RecordedLab& lab : labs_) ++times[lab.name];
  for (RecordedLab& lab : labs_)
    if (times[lab.name] > 1) lab.name = lab.folder.filename().string();
  std::ranges::sort(labs_, {}, &RecordedLab::name);
  const nlohmann::json result = hal::ResultFile(folder_).content();  // null: there is none
  if (!result.contains("absent_labs")) return;
  for (const auto& lab : result["absent_labs"])
    if (lab.is_string())
      left_out_.push_back(fmt::format("{} of shared.labs does not take part", lab.get<std::string>()));
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
  const hal::layout::Types& known = hal::layout::types();
  for (const RecordedLab& lab : labs_) {
    const Log& log = *lab.log;
    if (log.entries().empty()) out.push_back(fmt::format("{} holds no whole message", log.file().string()));
    if (!log.left_out().empty() && !is_written(lab))
      out.push_back(fmt::format("{} is cut or damaged: {} left out, and it is used up to {:.3f} s", log.file().string(),
                                log.left_out(), static_cast<double>(log.length_us()) / 1e6));
    if (log.moved() > 0)
      out.push_back(fmt::format("{} has {} with a time before that of the message ahead; each stands at that time",
                                log.file().string(), hal::counted(log.moved(), "message")));
    std::vector<std::string> strange;
    for (std::size_t i = 0; i < log.channels().size(); ++i) {
      const auto message = log.read(log.entries()[log.of_channel(i).front()]);
      if (known.of_channel(log.channels()[i]) && !type_of(message, known)) strange.push_back(log.channels()[i]);
    }
    if (strange.empty()) continue;
    out.push_back(fmt::format(
        "{} is of another version of arkmesh{}: its messages on {} are left out, for this is {} and has other types",
        log.file().string(), lab.version.empty() ? "" : fmt::format(" ({})", lab.version), fmt::join(strange, ", "),
        ARKMESH_VERSION));
  }
  return out;
}

std::vector<fs::path> runs_of_batch(const fs::path& folder) {
  std::vector<fs::path> out;
  for (const fs::path& below : folders_in(folder / "runs"))
    if (is_run(below)) out.push_back(below);
  return out;
}

}  // namespace arkmesh::recording
