#include "recording/view/recorded_view.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "hal/config.hpp"
#include "recording/view/moments.hpp"

namespace arkmesh::recording {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

constexpr std::int64_t max_moments = 10'000;
constexpr std::int64_t max_t_us = 1'000'000'000'000'000;  // 30 years; what is reckoned with times does not overflow
constexpr const char* too_much = "that is more than can wait for one viewer; ask for fewer moments or channels";

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

RecordedDesk::RecordedDesk(const std::vector<std::filesystem::path>& folders) {
  if (folders.empty() || folders.size() > 2)
    throw hal::ConfigError(fmt::format(
        "{} folders were given; the page shows one run, one batch, or two runs side by side", folders.size()));
  if (folders.size() == 1) batch_ = runs_of_batch(folders.front());
  open(batch_.empty() ? folders : std::vector{batch_.front()});
}

void RecordedDesk::open(const std::vector<std::filesystem::path>& folders) {
  std::vector<Run> runs;
  for (const auto& folder : folders) runs.emplace_back(folder);
  runs_ = std::move(runs);
  labs_.clear();
  comparison_.reset();
  for (std::size_t i = 0; i < runs_.size(); ++i)
    for (const RecordedLab& lab : runs_[i].labs()) {
      // two runs may have the same name in different folders
      const bool is_same = runs_.size() == 2 && runs_[0].name() == runs_[1].name();
      const std::string run = is_same ? fmt::format("{} ({})", runs_[i].name(), i + 1) : runs_[i].name();
      labs_.push_back({&lab, runs_.size() == 1 ? lab.name : run + "/" + lab.name});
    }
  if (labs_.size() > 255)
    throw hal::ConfigError(fmt::format("the runs have {} labs; the page shows 255", labs_.size()));
  if (runs_.size() == 2) comparison_ = compare(runs_[0], runs_[1]);
  is_growing_ = std::ranges::any_of(runs_, &Run::is_growing);
}

std::int64_t RecordedDesk::length_us() const {
  std::int64_t out = 0;
  for (const Run& run : runs_) out = std::max(out, run.length_us());
  return out;
}

void RecordedDesk::take_new() {
  const auto now = std::chrono::steady_clock::now();
  if (!is_growing_ || now - taken_ < 500ms) return;
  taken_ = now;
  // what was written before the end is still taken
  is_growing_ = std::ranges::any_of(runs_, &Run::is_growing);
  for (Run& run : runs_) run.refresh();
}

std::vector<std::string> RecordedDesk::notes() const {
  std::vector<std::string> out;
  for (const Run& run : runs_) {
    const auto more = run.notes();
    out.insert(out.end(), more.begin(), more.end());
  }
  if (comparison_) out.push_back(comparison_->in_words());
  return out;
}

json RecordedDesk::about() {
  take_new();
  json labs = json::array(), runs = json::array();
  for (const Lab& lab : labs_) labs.push_back(lab.name);
  std::string name;
  for (const Run& run : runs_) {
    name += (name.empty() ? "" : " and ") + run.name();
    if (batch_.empty()) runs.push_back(run.name());
  }
  for (const auto& run : batch_) runs.push_back(run.filename().string());
  json out = {{"mode", "recorded"},       {"labs", labs},           {"control", false}, {"run", name}, {"runs", runs},
              {"length_us", length_us()}, {"growing", is_growing_}, {"notes", notes()}};
  if (comparison_ && comparison_->first)
    out["first_difference"] = {
        {"period", comparison_->first->period}, {"lab", comparison_->first->lab}, {"t_us", comparison_->first->t_us}};
  return out;
}

void RecordedDesk::command(const json&, view::Answer& answer) {
  answer.refuse("this run is a recording; nothing in it takes commands");
}

void RecordedDesk::request(const json& what, view::Answer& answer) {
  take_new();
  if (const auto seek = what.find("seek"); seek != what.end()) return moment(*seek, answer);
  if (const auto frames = what.find("frames"); frames != what.end()) return row(*frames, answer);
  if (what.contains("events")) {
    json events = json::array();
    for (std::size_t i = 0; i < labs_.size(); ++i)
      for (const StoryEvent& event : events_of(*labs_[i].lab))
        events.push_back({{"t_us", event.t_us}, {"lab", i}, {"kind", event.kind}, {"text", event.text}});
    if (comparison_ && comparison_->first)
      events.push_back({{"t_us", comparison_->first->t_us},
                        {"lab", nullptr},
                        {"kind", "difference"},
                        {"text", comparison_->in_words()}});
    std::stable_sort(events.begin(), events.end(), [](const json& x, const json& y) {
      return x.at("t_us").get<std::int64_t>() < y.at("t_us").get<std::int64_t>();
    });
    if (!answer.done({{"events", events}})) answer.refuse(too_much);
    return;
  }
  if (what.contains("series")) {
    json all = json::array();
    for (const Lab& lab : labs_)
      for (const Series& series : series_of(*lab.lab))
        all.push_back({{"name", lab.name + "." + series.name}, {"t_s", series.t_s}, {"y", series.y}});
    if (!answer.done({{"series", all}})) answer.refuse(too_much);
    return;
  }
  if (const auto wanted = what.find("open"); wanted != what.end()) {
    const auto number = whole(*wanted, "run");
    if (!number || *number < 0 || *number >= static_cast<std::int64_t>(batch_.size()))
      return answer.refuse(fmt::format("open.run is the number of a run of the batch, from 0 to {}",
                                       static_cast<std::int64_t>(batch_.size()) - 1));
    open({batch_[static_cast<std::size_t>(*number)]});
    answer.done({{"about", about()}});
    return;
  }
  answer.refuse("a recording answers seek, frames, events, series and open");
}

void RecordedDesk::moment(const json& what, view::Answer& answer) {
  const auto t_us = whole(what, "t_us");
  if (!t_us) return answer.refuse("seek needs t_us, lab time in microseconds");
  for (std::size_t i = 0; i < labs_.size(); ++i) {
    const bool is_whole = give_moment(*labs_[i].lab->log, *t_us, channels_of(what),
                                      [&](std::int64_t t, const std::string& channel, auto message) {
                                        return answer.message(static_cast<int>(i), t, channel, message);
                                      });
    if (!is_whole) return answer.refuse(too_much);
  }
  answer.done({{"length_us", length_us()}, {"growing", is_growing_}});
}

void RecordedDesk::row(const json& what, view::Answer& answer) {
  const auto from_us = whole(what, "from_us"), step_us = whole(what, "step_us"), count = whole(what, "count");
  if (!from_us || !step_us || !count || *step_us < 1 || *count < 0 || *count > max_moments ||
      *step_us > max_t_us / max_moments)
    return answer.refuse(fmt::format("frames needs from_us, step_us above 0, and count up to {}", max_moments));
  for (std::size_t i = 0; i < labs_.size(); ++i) {
    const bool is_whole = give_row(*labs_[i].lab->log, {*from_us, *step_us, *count}, channels_of(what),
                                   [&](std::int64_t t, const std::string& channel, auto message) {
                                     return answer.message(static_cast<int>(i), t, channel, message);
                                   });
    if (!is_whole) return answer.refuse(too_much);
  }
  answer.done({{"length_us", length_us()}, {"growing", is_growing_}});
}

}  // namespace arkmesh::recording
