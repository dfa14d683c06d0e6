#include "hal/record/result_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>

#include "hal/files/replace_file.hpp"
#include "hal/files/whole_file.hpp"
#include "hal/handle.hpp"

namespace arkmesh::hal {

namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t largest_result_bytes = 64 << 20;
// In the order of Outcome.
constexpr std::array<std::string_view, 5> outcome_words = {"running", "finished", "stopped", "failed", "killed"};

std::string host_name() {
  std::array<char, 256> name{};
  ::gethostname(name.data(), name.size() - 1);
  return name.data();
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

// Null when there is no such member.
const nlohmann::json& member_of(const nlohmann::json& object, const char* key) {
  static const nlohmann::json none;
  const auto found = object.is_object() ? object.find(key) : object.end();
  return object.is_object() && found != object.end() ? *found : none;
}

std::string text_of(const nlohmann::json& object, const char* key) {
  const nlohmann::json& found = member_of(object, key);
  return found.is_string() ? found.get<std::string>() : std::string();
}

// 0 when there is none.
std::int64_t whole_number_of(const nlohmann::json& object, const char* key) {
  const nlohmann::json& found = member_of(object, key);
  return found.is_number_integer() ? found.get<std::int64_t>() : 0;
}

// On a full disk, or in a folder that takes no new file: the bytes that the file has hold what the run is and how it
// ended. False: not even that.
bool say_outcome_in_place(const fs::path& file, const nlohmann::json& result) {
  const auto before = whole_file(file, largest_result_bytes);
  const auto outcome = outcome_in(result);
  if (!before || !outcome) return false;
  nlohmann::json facts = nlohmann::json::parse(*before, nullptr, false);
  if (!facts.is_object()) return false;
  set_outcome(facts, *outcome, ended_in(result));
  if (facts.dump().size() > before->size()) set_outcome(facts, *outcome, "");
  std::string text = facts.dump();
  if (text.size() > before->size()) return false;
  text.resize(before->size(), ' ');
  const Handle handle(::open(file.c_str(), O_WRONLY | O_CLOEXEC));
  return handle && ::pwrite(handle.get(), text.data(), text.size(), 0) == static_cast<ssize_t>(text.size());
}

}  // namespace

std::optional<Outcome> outcome_in(const nlohmann::json& result) {
  const auto found = std::ranges::find(outcome_words, text_of(result, "state"));
  if (found == outcome_words.end()) return {};
  return static_cast<Outcome>(found - outcome_words.begin());
}

std::string ended_in(const nlohmann::json& result) {
  return text_of(result, "ended");
}

void set_outcome(nlohmann::json& result, Outcome outcome, std::string_view ended) {
  const std::string_view word = outcome_words[static_cast<std::size_t>(outcome)];
  result["state"] = word;
  result["ended"] = ended.empty() ? word : ended;
}

ResultFile::ResultFile(const fs::path& folder) : file_(folder / "result.json") {
  const auto text = whole_file(file_, largest_result_bytes);
  if (text) content_ = nlohmann::json::parse(*text, nullptr, false);
  if (!content_.is_object()) content_ = {};
}

std::string ResultFile::text(const char* key) const {
  return text_of(content_, key);
}

std::vector<std::string> ResultFile::labs() const {
  std::vector<std::string> out;
  const nlohmann::json& names = member_of(content_, "labs");
  if (names.is_array())
    for (const nlohmann::json& each : names)
      if (const std::string name = each.is_string() ? each.get<std::string>() : "";
          !name.empty() && name != "." && name != ".." && name.find('/') == std::string::npos)
        out.push_back(name);
  return out;
}

const nlohmann::json& ResultFile::process() const {
  return member_of(content_, "process");
}

std::int64_t ResultFile::process_id() const {
  return std::max<std::int64_t>(0, whole_number_of(process(), "pid"));
}

ResultFile::Runs ResultFile::runs() const {
  if (outcome() != Outcome::running || !process().is_object()) return Runs::no;
  if (text_of(process(), "host") != host_name()) return Runs::unknown;
  const std::int64_t ticks = began(process_id());
  return ticks > 0 && ticks == whole_number_of(process(), "began_ticks") ? Runs::yes : Runs::no;
}

std::string ResultFile::goes_on_in_words() const {
  if (runs() == Runs::no) return {};
  return fmt::format("the run of {} (process {}), which is still in progress", fmt::join(labs(), ", "), process_id());
}

bool ResultFile::mark_killed() {
  if (outcome() != Outcome::running || !process().is_object() || runs() != Runs::no) return false;
  set_outcome(content_, Outcome::killed, fmt::format("killed: process {} ended without a result", process_id()));
  replace_json(file_, content_);
  return true;
}

int replace_json(const fs::path& file, const nlohmann::json& json) {
  return replace_file(file, json.dump(2) + "\n");
}

int save_running(const fs::path& file, nlohmann::json facts) {
  set_outcome(facts, Outcome::running);
  return replace_json(file, facts);
}

void save_json(const fs::path& file, const nlohmann::json& json) {
  const int error = replace_json(file, json);
  if (error == 0) return;
  spdlog::warn("{} cannot be written ({}); it is printed instead", file.string(), std::strerror(error));
  std::puts(json.dump(2).c_str());
  if (!say_outcome_in_place(file, json))
    spdlog::warn("{} still says that the run is in progress; the printed text is its result", file.string());
}

nlohmann::json own_process() {
  return {{"pid", ::getpid()}, {"began_ticks", began(::getpid())}, {"host", host_name()}};
}

}  // namespace arkmesh::hal
