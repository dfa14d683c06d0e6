#include "app/recorded_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "app/arenas.hpp"
#include "app/batch/batch_folder.hpp"
#include "app/batch/plain_json.hpp"
#include "lab/result.hpp"

namespace arkmesh::app {
namespace {

namespace fs = std::filesystem;

fs::path folder_of(const fs::path& place, std::optional<std::size_t> index) {
  std::error_code error;
  const bool is_folder = fs::is_directory(place, error);
  const std::string name = place.filename().string();
  if (!is_folder && name != "result.json" && name != "config.toml" && name != "manifest.json")
    throw hal::ConfigError(
        fmt::format("{} is neither a run's folder nor its result.json or config.toml", place.string()));
  fs::path folder = is_folder ? place : fs::absolute(place).parent_path();
  const bool is_batch = fs::exists(folder / "manifest.json", error);
  if (error) throw hal::ConfigError(fmt::format("{} cannot be read: {}", folder.string(), error.message()));
  if (is_batch && !index)
    throw hal::ConfigError(fmt::format("{} is a batch; choose one of its runs with --index", folder.string()));
  if (!is_batch && index) throw hal::ConfigError(fmt::format("--index: {} is not a batch", folder.string()));
  return is_batch ? BatchFolder::run_folder(folder, *index) : folder;
}

// The rows of a hash.csv, the header first, without its column `period`.
std::vector<std::vector<std::string>> hash_rows(const fs::path& file) {
  std::ifstream in(file);
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(in, line);) {
    std::istringstream cells(line);
    std::vector<std::string>& row = rows.emplace_back();
    std::string cell;
    for (std::getline(cells, cell, ','); std::getline(cells, cell, ',');) row.push_back(cell);
  }
  return rows;
}

}  // namespace

RecordedRun::RecordedRun(const fs::path& place, std::optional<std::size_t> index)
    : folder_(folder_of(place, index)), result_(folder_) {
  if (!result_.exists() || !result_.content().contains("labs"))
    throw hal::ConfigError(fmt::format("{} holds no result.json of a run", folder_.string()));
  const auto outcome = result_.outcome();
  if (outcome == hal::Outcome::running)
    throw hal::ConfigError(
        fmt::format("the run of {} is unfinished, so there is no result to compare with", folder_.string()));
  if (outcome != hal::Outcome::finished && outcome != hal::Outcome::failed)
    throw hal::ConfigError(fmt::format("the run of {} is {}, so there is no result to compare with", folder_.string(),
                                       outcome ? result_.text("state") : "in an unknown state"));
  if (result_.text("gate") != "strict")
    throw hal::ConfigError(
        fmt::format("the run of {} was in real time, and cannot be repeated exactly", folder_.string()));
  find_labs();
}

void RecordedRun::find_labs() {
  const nlohmann::json& labs = result_.content().at("labs");
  const bool are_names = labs.is_array() && !labs.empty() && std::ranges::all_of(labs, [](const nlohmann::json& lab) {
                           return lab.is_string() && !lab.get<std::string>().empty() &&
                                  lab.get<std::string>().find('/') == std::string::npos;
                         });
  if (!are_names) throw hal::ConfigError(fmt::format("{} names no labs", (folder_ / "result.json").string()));
  // one lab's own result names it, and the others lie beside
  const std::string own = result_.text("lab");
  const bool is_lab = !own.empty() && !fs::is_directory(folder_ / own);
  for (const std::string lab : labs) {
    const fs::path folder = !is_lab      ? folder_ / lab
                            : lab == own ? folder_
                                         : fs::absolute(folder_ / "").parent_path().parent_path() / lab;
    if (!fs::is_regular_file(folder / "config.toml"))
      throw hal::ConfigError(fmt::format("there is no {}; repeating a run needs the folders of all its labs",
                                         (folder / "config.toml").string()));
    lab_folders_.push_back(folder);
    config_files_.push_back((folder / "config.toml").string());
  }
}

std::vector<hal::Config> RecordedRun::configs() const {
  std::vector<hal::Config> out;
  for (const std::string& file : config_files_) out.push_back(hal::Config::from_file(file, {"recorder.log=false"}));
  return out;
}

std::vector<std::string> RecordedRun::changes() const {
  std::vector<std::string> out;
  const nlohmann::json now = lab::program_facts();
  const auto version = [](const nlohmann::json& facts) {
    return fmt::format("{} (commit {})", text_in(facts, "arkmesh", "?"),
                       text_in(object_in(facts, "versions"), "commit", "?").substr(0, 12));
  };
  if (version(result_.content()) != version(now))
    out.push_back(
        fmt::format("the run was made by arkmesh {}, but this is {}", version(result_.content()), version(now)));
  for (std::size_t i = 0; i < lab_folders_.size(); ++i) {
    const hal::ResultFile result(lab_folders_[i]);
    const nlohmann::json& hashes = object_in(result.content(), "hashes");
    const auto config = hal::Config::from_file(config_files_[i]);
    std::vector<fs::path> files = robots_programs_of(config.root().section("arena"));
    files.emplace_back(config_files_[i]);
    for (const auto& [name, then] : hashes.items()) {
      const auto file = std::ranges::find(files, name, [](const fs::path& one) { return one.filename().string(); });
      if (file == files.end())
        out.push_back(fmt::format("{}, which the run used, is missing", name));
      else if (then != lab::file_hash(*file))
        out.push_back(fmt::format("{} has changed since the run", file->string()));
    }
  }
  return out;
}

std::string RecordedRun::first_difference(const fs::path& folder) const {
  const auto then = hash_rows(folder_ / "hash.csv"), now = hash_rows(folder / "hash.csv");
  if (then.empty() || now.empty() || then.front() != now.front()) return {};
  for (std::size_t row = 1; row < then.size() && row < now.size(); ++row)
    for (std::size_t i = 0; i < then[row].size() && i < now[row].size(); ++i)
      if (then[row][i] != now[row][i]) return fmt::format("period {}, lab {}", row - 1, then.front()[i]);
  return {};
}

}  // namespace arkmesh::app
