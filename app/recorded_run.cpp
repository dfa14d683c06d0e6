#include "app/recorded_run.hpp"

#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "app/batch_folder.hpp"
#include "lab/result.hpp"

namespace arkmesh::app {
namespace {

namespace fs = std::filesystem;

nlohmann::json read_json(const fs::path& file) {
  std::ifstream in(file);
  return in ? nlohmann::json::parse(in, nullptr, false) : nlohmann::json();
}

fs::path folder_of(const fs::path& place, std::optional<std::size_t> index) {
  const bool is_folder = fs::is_directory(place);
  const std::string name = place.filename().string();
  if (!is_folder && name != "result.json" && name != "config.toml" && name != "manifest.json")
    throw hal::ConfigError(
        fmt::format("{} is neither a run's folder nor its result.json or config.toml", place.string()));
  fs::path folder = is_folder ? place : fs::absolute(place).parent_path();
  const bool is_batch = fs::exists(folder / "manifest.json");
  if (is_batch && !index)
    throw hal::ConfigError(fmt::format("{} is a batch; say with --index which of its runs", folder.string()));
  if (!is_batch && index) throw hal::ConfigError(fmt::format("--index: {} is no batch", folder.string()));
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
    : folder_(folder_of(place, index)), result_(read_json(folder_ / "result.json")) {
  if (!result_.is_object() || !result_.contains("labs"))
    throw hal::ConfigError(fmt::format("{} holds no result.json of a run", folder_.string()));
  const std::string state = result_.value("state", "");
  if (state != "finished" && state != "failed")
    throw hal::ConfigError(fmt::format("the run of {} is {}, so there is no result to compare with", folder_.string(),
                                       state.empty() ? "of an unknown state" : state));
  if (result_.value("gate", "") != "strict")
    throw hal::ConfigError(
        fmt::format("the run of {} kept real time, and real time does not repeat itself", folder_.string()));
  find_labs();
}

void RecordedRun::find_labs() {
  const auto labs = result_.value("labs", std::vector<std::string>());
  // one lab's own result names it, and the others lie beside
  const bool is_lab = result_.contains("lab") && !fs::is_directory(folder_ / result_.value("lab", ""));
  for (const std::string& lab : labs) {
    const fs::path folder = !is_lab ? folder_ / lab
                            : lab == result_.value("lab", "")
                                ? folder_
                                : fs::absolute(folder_ / "").parent_path().parent_path() / lab;
    if (!fs::is_regular_file(folder / "config.toml"))
      throw hal::ConfigError(fmt::format("there is no {}; a run is repeated from the folders of all of its labs",
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
  const nlohmann::json now = lab::program_facts(), none = nlohmann::json::object();
  const auto commit = [&](const nlohmann::json& facts) { return facts.value("versions", none).value("commit", "?"); };
  if (result_.value("arkmesh", "?") != now.value("arkmesh", "?") || commit(result_) != commit(now))
    out.push_back(fmt::format("the run is of arkmesh {} (commit {}), and this is {} (commit {})",
                              result_.value("arkmesh", "?"), commit(result_).substr(0, 12), now.value("arkmesh", "?"),
                              commit(now).substr(0, 12)));
  for (std::size_t i = 0; i < lab_folders_.size(); ++i) {
    const nlohmann::json hashes = read_json(lab_folders_[i] / "result.json").value("hashes", none);
    const auto config = hal::Config::from_file(config_files_[i]);
    const auto program = config.root().section("arena").section("ode").get("controller", fs::path());
    for (const fs::path& file : {fs::path(config_files_[i]), program})
      if (const std::string then = hashes.value(file.filename().string(), "");
          !then.empty() && then != lab::file_hash(file))
        out.push_back(fmt::format("{} was changed since the run", file.string()));
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
