#include "recording/view/run_story.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "hal/counted.hpp"
#include "hal/layout/message.hpp"
#include "recording/csv_table.hpp"

namespace arkmesh::recording {
namespace {

using namespace hal::layout;

namespace fs = std::filesystem;

constexpr std::size_t max_events = 5000;

// Single values of a message by name, of records in lists for each element by the element's first text.
class Values : public Visitor {
 public:
  void value(const Field& field, const Value& value) override {
    const std::string text = value.kind == Kind::text ? std::string(value.text) : std::to_string(value.integer);
    if (depth_ == 0) {
      own[field.name] = text;
      return;
    }
    if (depth_ == 1 && !elements.empty()) elements.back()[field.name] = text;
  }
  void bytes(const Field&, std::span<const std::byte>) override {}
  void begin_list(const Field&, std::size_t) override {}
  void end_list(const Field&) override {}
  void begin_record(const Field&, std::size_t) override {
    if (depth_++ == 0) elements.emplace_back();
  }
  void end_record(const Field&) override { --depth_; }

  std::map<std::string, std::string, std::less<>> own;
  std::vector<std::map<std::string, std::string, std::less<>>> elements;

 private:
  int depth_ = 0;
};

const char* command_word(const std::string& number) {
  // fleet_command_t and operator_command_t
  static const std::map<std::string, const char*, std::less<>> words = {
      {"0", "run"},    {"1", "pause"},     {"2", "reset"},    {"3", "sleep"}, {"4", "voltage"},
      {"5", "charge"}, {"6", "broadcast"}, {"253", "disarm"}, {"254", "arm"}, {"255", "stop"}};
  const auto found = words.find(number);
  return found == words.end() ? "another command" : found->second;
}

// Of counts that the scenario shows as curves; a row once in a second.
constexpr const char* counts_table = "curves";
constexpr std::size_t max_counts = 50;

std::vector<fs::path> tables_in(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".csv" && entry.is_regular_file(error)) out.push_back(entry.path());
  std::ranges::sort(out);
  return out;
}

// Whether rows come at even times: such a table samples something, and another one lists what happened.
bool is_even(const CsvTable& table, std::size_t time) {
  if (table.rows < 3) return false;
  const double step = table.number(time, 1) - table.number(time, 0);
  for (std::size_t i = 1; i < table.rows; ++i)
    if (!(std::abs(table.number(time, i) - table.number(time, i - 1) - step) <= 1e-6)) return false;
  return step > 0;
}

void add_messages(const RecordedLab& lab, std::vector<StoryEvent>& to) {
  const Log& log = *lab.log;
  std::string state;
  std::map<std::string, std::string> links;
  for (const Log::Entry& entry : log.entries()) {
    const std::string& channel = log.channels()[entry.channel];
    const bool is_operators = channel == "operator_command" || channel.ends_with("/operator_command");
    if (channel != "fleet_command" && channel != "status" && channel != "peers" && !is_operators) continue;
    const auto message = log.read(entry);
    const Type* const type = type_of(message, types());
    if (!type || !check(*type, message).empty()) continue;
    Values values;
    visit(*type, message, values);
    if (channel == "fleet_command")
      to.push_back({entry.t_us, "command", fmt::format("{} to all robots", command_word(values.own["command"]))});
    if (is_operators && !values.elements.empty()) {
      const std::string who = channel.find('/') == std::string::npos
                                  ? "the operator"
                                  : "the operator of " + channel.substr(0, channel.find('/'));
      to.push_back(
          {entry.t_us, "command", fmt::format("{} by {}", command_word(values.elements.front()["command"]), who)});
    }
    if (channel == "status" && values.own["state"] != state)
      to.push_back({entry.t_us, "state", state = values.own["state"]});
    if (channel == "peers")
      for (const auto& peer : values.elements) {
        const auto name = peer.find("lab"), up = peer.find("up"), why = peer.find("why");
        if (name == peer.end() || up == peer.end()) continue;
        const std::string now =
            fmt::format("link to {} {}{}", name->second, up->second == "1" ? "up" : "down",
                        up->second == "1" || why == peer.end() || why->second.empty() ? "" : ": " + why->second);
        if (links[name->second] != now) to.push_back({entry.t_us, "link", links[name->second] = now});
      }
  }
}

void add_rows(const RecordedLab& lab, std::vector<StoryEvent>& to) {
  for (const fs::path& file : tables_in(lab.folder)) {
    const CsvTable table = read_csv_table(file);
    const auto time = table.find("time_s");
    if (!time || is_even(table, *time) || file.stem() == counts_table) continue;
    for (std::size_t i = 0; i < table.rows; ++i) {
      const double t_s = table.number(*time, i);
      if (!(std::abs(t_s) < 1e9)) continue;
      std::string text = file.stem().string();
      for (std::size_t c = 0; c < table.columns.size(); ++c)
        if (c != *time)
          text += fmt::format("{} {} {}", c == 0 || (c == 1 && *time == 0) ? ":" : ",", table.columns[c].name,
                              table.columns[c].texts[i]);
      to.push_back({static_cast<std::int64_t>(std::llround(t_s * 1e6)), file.stem().string(), std::move(text)});
    }
  }
}

// What the scenario has counted otherwise, from the lab's status messages.
void add_counts(const RecordedLab& lab, std::vector<Series>& to) {
  constexpr std::string_view counts = "counts.";
  const auto channel = lab.log->find_channel("status");
  if (!channel) return;
  std::map<std::string, Series, std::less<>> found;
  for (const std::size_t at : lab.log->of_channel(*channel)) {
    const auto message = lab.log->read(lab.log->entries()[at]);
    const Type* const type = type_of(message, types());
    if (!type || !check(*type, message).empty()) continue;
    Values values;
    visit(*type, message, values);
    const double t_s = std::strtod(values.own["stamp_us"].c_str(), nullptr) * 1e-6;
    for (auto& counter : values.elements) {
      if (!counter["name"].starts_with(counts)) continue;
      const std::string name = counter["name"].substr(counts.size());
      if (std::ranges::find(to, name, &Series::name) != to.end()) continue;
      if (!found.contains(name) && found.size() >= max_counts) continue;
      Series& series = found.try_emplace(name, Series{name, {}, {}}).first->second;
      if (!series.t_s.empty() && t_s <= series.t_s.back()) continue;
      series.t_s.push_back(t_s);
      series.y.push_back(std::strtod(counter["value"].c_str(), nullptr));
    }
  }
  for (auto& [name, series] : found) to.push_back(std::move(series));
}

}  // namespace

std::vector<StoryEvent> events_of(const RecordedLab& lab) {
  std::vector<StoryEvent> out;
  add_messages(lab, out);
  add_rows(lab, out);
  std::ranges::stable_sort(out, {}, &StoryEvent::t_us);
  if (out.size() > max_events) {
    const std::size_t more = out.size() - max_events;
    out.resize(max_events);
    out.push_back({out.back().t_us, "state", fmt::format("{} further events are not listed", more)});
  }
  return out;
}

std::vector<Series> series_of(const RecordedLab& lab) {
  std::vector<Series> out;
  for (const fs::path& file : tables_in(lab.folder)) {
    const CsvTable table = read_csv_table(file);
    const auto time = table.find("time_s");
    if (!time) continue;
    std::vector<double> t_s;
    for (std::size_t i = 0; i < table.rows; ++i) t_s.push_back(table.number(*time, i));
    const bool is_counts = file.stem() == counts_table;
    if (!is_counts && !is_even(table, *time)) {
      Series count{file.stem().string(), {0}, {0}};
      for (std::size_t i = 0; i < table.rows; ++i) {
        count.t_s.push_back(t_s[i]);
        count.y.push_back(static_cast<double>(i + 1));
      }
      out.push_back(std::move(count));
      continue;
    }
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      if (c == *time || table.columns[c].name == "period" || table.columns[c].kind == CsvTable::text) continue;
      Series one{(is_counts ? "" : file.stem().string() + ".") + table.columns[c].name, t_s, {}};
      if (std::ranges::find(out, one.name, &Series::name) != out.end()) continue;
      for (std::size_t i = 0; i < table.rows; ++i) one.y.push_back(table.number(c, i));
      out.push_back(std::move(one));
    }
  }
  add_counts(lab, out);
  return out;
}

Comparison compare(const Run& a, const Run& b) {
  Comparison out;
  for (const RecordedLab& lab : a.labs()) {
    const auto other = std::ranges::find(b.labs(), lab.name, &RecordedLab::name);
    if (other == b.labs().end()) continue;
    const CsvTable here = read_csv_table(lab.folder / "hash.csv"), there = read_csv_table(other->folder / "hash.csv");
    const auto hash_here = here.find("hash"), hash_there = there.find("hash");
    if (!hash_here || !hash_there) continue;
    ++out.labs;
    const std::size_t rows = std::min(here.rows, there.rows);
    out.periods = std::max(out.periods, rows);
    for (std::size_t i = 0; i < rows; ++i) {
      if (here.columns[*hash_here].texts[i] == there.columns[*hash_there].texts[i]) continue;
      if (out.first && out.first->period <= static_cast<std::int64_t>(i)) break;
      out.first = Difference{static_cast<std::int64_t>(i), lab.name, 0};
      if (const auto shared = lab.log->find_channel("shared"); shared && i < lab.log->of_channel(*shared).size())
        out.first->t_us = lab.log->entries()[lab.log->of_channel(*shared)[i]].t_us;
      break;
    }
  }
  return out;
}

std::string Comparison::in_words() const {
  if (labs == 0) return "no lab has a hash.csv in both runs";
  if (!first) return fmt::format("the runs are equal in all {} that both have", hal::counted(periods, "period"));
  return fmt::format("the runs first differ in period {}, in lab {}, at {:g} s", first->period, first->lab,
                     static_cast<double>(first->t_us) / 1e6);
}

}  // namespace arkmesh::recording
