#include "recording/view/recorded_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

#include "hal/config/config.hpp"
#include "recording/csv_table.hpp"
#include "recording/view/moments.hpp"

namespace arkmesh::recording {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

constexpr std::size_t max_opened = 32;
constexpr std::int64_t max_moments = 10'000;
constexpr std::size_t max_rows = 5000, max_columns = 200;  // of a batch's table
constexpr std::int64_t max_t_us = 1'000'000'000'000'000;   // 30 years; what is reckoned with times does not overflow
constexpr const char* too_much =
    "the answer is larger than the buffer of one viewer; ask for fewer moments or channels";

// A whole number of a request, or nothing.
std::optional<std::int64_t> whole(const json& object, const char* key) {
  const auto found = object.is_object() ? object.find(key) : object.end();
  if (!object.is_object() || found == object.end() || !found->is_number()) return {};
  const double value = found->get<double>();
  if (!(value >= -static_cast<double>(max_t_us) && value <= static_cast<double>(max_t_us))) return {};
  return static_cast<std::int64_t>(value);
}

std::vector<std::string> channels_of(const json& object) {
  std::vector<std::string> out;
  const auto found = object.find("channels");
  if (found == object.end() || !found->is_array()) return out;
  for (const json& name : *found)
    if (name.is_string()) out.push_back(name.get<std::string>());
  return out;
}

}  // namespace

RecordedDesk::RecordedDesk(const std::vector<std::filesystem::path>& folders) : folders_(folders) {
  if (folders.empty() || folders.size() > 2)
    throw hal::ConfigError(fmt::format(
        "{} folders were given; the page shows one run, one batch, or two runs side by side", folders.size()));
  if (folders.size() == 1) batch_ = runs_of_batch(folders.front());
  named_in(json::object());
}

RecordedDesk::Opened::Opened(const std::vector<std::filesystem::path>& folders, std::size_t its_number)
    : number(its_number) {
  for (const auto& folder : folders) runs.emplace_back(folder);
  for (std::size_t i = 0; i < runs.size(); ++i)
    for (const RecordedLab& lab : runs[i].labs()) {
      // two runs may have the same name in different folders
      const bool is_same = runs.size() == 2 && runs[0].name() == runs[1].name();
      const std::string run = is_same ? fmt::format("{} ({})", runs[i].name(), i + 1) : runs[i].name();
      labs.push_back({&lab, runs.size() == 1 ? lab.name : run + "/" + lab.name});
    }
  if (labs.size() > 255) throw hal::ConfigError(fmt::format("the runs have {} labs; the page shows 255", labs.size()));
  if (runs.size() == 2) comparison = compare(runs[0], runs[1]);
  is_growing = std::ranges::any_of(runs, &Run::is_growing);
}

RecordedDesk::Opened& RecordedDesk::named_in(const json& object) {
  const std::size_t count = std::max<std::size_t>(1, batch_.size());
  const auto number = object.contains("run") ? whole(object, "run") : 0;
  if (!number || *number < 0 || std::cmp_greater_equal(*number, count))
    throw hal::ConfigError(fmt::format("run must be the number of a run, from 0 to {}", count - 1));
  const auto wanted = static_cast<std::size_t>(*number);
  if (const auto found = std::ranges::find(opened_, wanted, &Opened::number); found != opened_.end())
    opened_.splice(opened_.begin(), opened_, found);
  else
    opened_.emplace_front(batch_.empty() ? folders_ : std::vector{batch_[wanted]}, wanted);
  if (opened_.size() > max_opened) {
    // the first run stays: whoever comes is told of it, also when its folder is gone meanwhile
    const auto last = std::prev(opened_.end());
    opened_.erase(last->number == 0 ? std::prev(last) : last);
  }
  opened_.front().take_new();
  return opened_.front();
}

std::int64_t RecordedDesk::Opened::length_us() const {
  std::int64_t out = 0;
  for (const Run& run : runs) out = std::max(out, run.length_us());
  return out;
}

void RecordedDesk::Opened::take_new() {
  const auto now = std::chrono::steady_clock::now();
  if (!is_growing || now - taken < 500ms) return;
  taken = now;
  // what was written before the end is still taken
  is_growing = std::ranges::any_of(runs, &Run::is_growing);
  for (Run& run : runs) run.refresh();
}

std::vector<std::string> RecordedDesk::Opened::notes() const {
  std::vector<std::string> out;
  for (const Run& run : runs) {
    const auto more = run.notes();
    out.insert(out.end(), more.begin(), more.end());
  }
  if (comparison) out.push_back(comparison->in_words());
  return out;
}

std::vector<std::string> RecordedDesk::notes() const {
  return opened_.front().notes();
}

json RecordedDesk::about() {
  return about(named_in(json::object()));
}

json RecordedDesk::about(Opened& shown) const {
  json labs = json::array(), runs = json::array();
  for (const Lab& lab : shown.labs) labs.push_back(lab.name);
  std::string name;
  for (const Run& run : shown.runs) {
    name += (name.empty() ? "" : " and ") + run.name();
    if (batch_.empty()) runs.push_back(run.name());
  }
  for (const auto& run : batch_) runs.push_back(run.filename().string());
  json out = {{"mode", "recorded"},
              {"labs", labs},
              {"control", false},
              {"run", name},
              {"runs", runs},
              {"number", shown.number},
              {"length_us", shown.length_us()},
              {"growing", shown.is_growing},
              {"notes", shown.notes()}};
  if (shown.comparison && shown.comparison->first) {
    const Difference& first = *shown.comparison->first;
    out["first_difference"] = {{"period", first.period}, {"lab", first.lab}, {"t_us", first.t_us}};
  }
  return out;
}

void RecordedDesk::command(const json&, view::Answer& answer) {
  answer.refuse("this run is a recording and accepts no commands");
}

void RecordedDesk::request(const json& what, view::Answer& answer) {
  if (const auto open = what.find("open"); open != what.end()) {
    if (!open->is_object() || !open->contains("run")) return answer.refuse("open needs run, the number of a run");
    answer.done({{"about", about(named_in(*open))}});
    return;
  }
  if (what.contains("batch")) return table(answer);
  const Opened& shown = named_in(what);
  if (const auto seek = what.find("seek"); seek != what.end()) return shown.moment(*seek, answer);
  if (const auto frames = what.find("frames"); frames != what.end()) return shown.row(*frames, answer);
  if (what.contains("events")) return shown.events(answer);
  if (what.contains("series")) return shown.series(answer);
  answer.refuse("a recording answers seek, frames, events, series, open and batch");
}

void RecordedDesk::table(view::Answer& answer) const {
  if (batch_.empty()) return answer.refuse("this is not a batch but one run, or two in comparison");
  const std::filesystem::path folder = batch_.front().parent_path().parent_path();
  const CsvTable runs = read_csv_table(folder / "runs.csv");
  const auto number = runs.find("run"), seed = runs.find("seed");
  if (!number || !seed || *seed < 2)
    return answer.refuse(
        "runs.csv is not complete yet; it is written when the batch ends, or by arkmesh batch --gather");
  const std::size_t columns = std::min(runs.columns.size(), max_columns);
  std::map<std::string, std::size_t> recorded;
  for (std::size_t i = 0; i < batch_.size(); ++i) recorded.emplace(batch_[i].filename().string(), i);
  json names = json::array(), rows = json::array();
  for (std::size_t c = 0; c < columns; ++c) names.push_back(runs.columns[c].name);
  for (std::size_t row = 0; row < std::min(runs.rows, max_rows); ++row) {
    const auto found = recorded.find(fmt::format("{:0>5}", runs.columns[*number].texts[row]));
    json cells = json::array();
    for (std::size_t c = 0; c < columns; ++c) cells.push_back(runs.columns[c].texts[row]);
    rows.push_back({{"run", found == recorded.end() ? json() : json(found->second)}, {"cells", cells}});
  }
  const json table = {{"name", folder.filename().string()}, {"columns", names}, {"factors", *seed - 2}, {"rows", rows}};
  if (!answer.done({{"batch", table}})) answer.refuse(too_much);
}

void RecordedDesk::Opened::events(view::Answer& answer) const {
  json events = json::array();
  for (std::size_t i = 0; i < labs.size(); ++i)
    for (const StoryEvent& event : events_of(*labs[i].lab))
      events.push_back({{"t_us", event.t_us}, {"lab", i}, {"kind", event.kind}, {"text", event.text}});
  if (comparison && comparison->first)
    events.push_back({{"t_us", comparison->first->t_us},
                      {"lab", nullptr},
                      {"kind", "difference"},
                      {"text", comparison->in_words()}});
  std::stable_sort(events.begin(), events.end(), [](const json& x, const json& y) {
    return x.at("t_us").get<std::int64_t>() < y.at("t_us").get<std::int64_t>();
  });
  if (!answer.done({{"events", events}})) answer.refuse(too_much);
}

void RecordedDesk::Opened::series(view::Answer& answer) const {
  json all = json::array();
  for (const Lab& lab : labs)
    for (const Series& series : series_of(*lab.lab))
      all.push_back({{"name", lab.name + "." + series.name}, {"t_s", series.t_s}, {"y", series.y}});
  if (!answer.done({{"series", all}})) answer.refuse(too_much);
}

void RecordedDesk::Opened::moment(const json& what, view::Answer& answer) const {
  const auto t_us = whole(what, "t_us");
  if (!t_us) return answer.refuse("seek needs t_us, lab time in microseconds");
  for (std::size_t i = 0; i < labs.size(); ++i) {
    const bool is_whole = give_moment(*labs[i].lab->log, *t_us, channels_of(what),
                                      [&](std::int64_t t, const std::string& channel, auto message) {
                                        return answer.message(static_cast<int>(i), t, channel, message);
                                      });
    if (!is_whole) return answer.refuse(too_much);
  }
  answer.done({{"length_us", length_us()}, {"growing", is_growing}});
}

void RecordedDesk::Opened::row(const json& what, view::Answer& answer) const {
  const auto from_us = whole(what, "from_us"), step_us = whole(what, "step_us"), count = whole(what, "count");
  if (!from_us || !step_us || !count || *step_us < 1 || *count < 0 || *count > max_moments ||
      *step_us > max_t_us / max_moments)
    return answer.refuse(fmt::format("frames needs from_us, step_us above 0, and count up to {}", max_moments));
  for (std::size_t i = 0; i < labs.size(); ++i) {
    const bool is_whole = give_row(*labs[i].lab->log, {*from_us, *step_us, *count}, channels_of(what),
                                   [&](std::int64_t t, const std::string& channel, auto message) {
                                     return answer.message(static_cast<int>(i), t, channel, message);
                                   });
    if (!is_whole) return answer.refuse(too_much);
  }
  answer.done({{"length_us", length_us()}, {"growing", is_growing}});
}

}  // namespace arkmesh::recording
