// Reading keys: types, ranges, defaults. What is in force is noted for the effective configuration.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "hal/config.hpp"
#include "hal/config_shared.hpp"

namespace arkmesh::hal {

namespace fs = std::filesystem;

namespace {

std::string range_sentence(auto low, auto high, bool has_low, bool has_high) {
  if (has_low && has_high) return fmt::format("must be between {} and {}", low, high);
  return has_low ? fmt::format("must be at least {}", low) : fmt::format("must be at most {}", high);
}

// The value as a number, or nothing when it is none.
std::optional<double> as_number(const ConfigValue& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value.content)) return static_cast<double>(*whole);
  if (const auto* number = std::get_if<double>(&value.content)) return *number;
  return {};
}

// Why a number will not do; empty when it will.
std::string number_complaint(double number, Range range) {
  if (!std::isfinite(number)) return "must be a finite number";
  if (number >= range.low && number <= range.high) return {};
  return range_sentence(range.low, range.high, std::isfinite(range.low), std::isfinite(range.high));
}

std::string list_to_toml(const auto& list) {
  std::string out = "[";
  for (const auto& element : list) out += (out.size() > 1 ? ", " : "") + to_toml(element);
  return out + "]";
}

}  // namespace

double Section::number(std::string_view key, double otherwise, Range range) const {
  const std::string full = join_key(path_, key);
  double out = otherwise;
  if (const ConfigValue* value = shared_->find(full, "a number")) {
    const auto number = as_number(*value);
    if (!number) shared_->refuse(full, "must be a number");
    if (const std::string why = number_complaint(*number, range); !why.empty()) shared_->refuse(full, why);
    out = *number;
  }
  shared_->in_force[full] = to_toml(out);
  return out;
}

std::int64_t Section::integer(std::string_view key, std::int64_t otherwise, std::int64_t low, std::int64_t high) const {
  const std::string full = join_key(path_, key);
  std::int64_t out = otherwise;
  if (const ConfigValue* value = shared_->find(full, "a whole number")) {
    const auto* whole = std::get_if<std::int64_t>(&value->content);
    if (!whole) shared_->refuse(full, "must be a whole number");
    using Limits = std::numeric_limits<std::int64_t>;
    if (*whole < low || *whole > high)
      shared_->refuse(full, range_sentence(low, high, low != Limits::min(), high != Limits::max()));
    out = *whole;
  }
  shared_->in_force[full] = fmt::format("{}", out);
  return out;
}

bool Section::flag(std::string_view key, bool otherwise) const {
  const std::string full = join_key(path_, key);
  bool out = otherwise;
  if (const ConfigValue* value = shared_->find(full, "true or false")) {
    const auto* flag = std::get_if<bool>(&value->content);
    if (!flag) shared_->refuse(full, "must be true or false");
    out = *flag;
  }
  shared_->in_force[full] = out ? "true" : "false";
  return out;
}

std::string Section::text(std::string_view key, std::string_view otherwise) const {
  const std::string full = join_key(path_, key);
  std::string out(otherwise);
  if (const ConfigValue* value = shared_->find(full, "a text")) {
    const auto* text = std::get_if<std::string>(&value->content);
    if (!text) shared_->refuse(full, "must be a text in quotes");
    out = *text;
  }
  shared_->in_force[full] = to_toml(out);
  return out;
}

std::string Section::choice(std::string_view key, std::string_view otherwise,
                            const std::vector<std::string>& allowed) const {
  std::string out = text(key, otherwise);
  if (std::find(allowed.begin(), allowed.end(), out) == allowed.end()) {
    std::string names;
    for (std::size_t i = 0; i < allowed.size(); ++i)
      names += (i == 0 ? "" : i + 1 == allowed.size() ? " or " : ", ") + to_toml(allowed[i]);
    refuse(key, fmt::format("must be {}", names));
  }
  return out;
}

std::vector<std::string> Section::texts(std::string_view key, const std::vector<std::string>& otherwise) const {
  const std::string full = join_key(path_, key);
  std::vector<std::string> out = otherwise;
  if (const ConfigValue* value = shared_->find(full, "a list of texts")) {
    const auto* list = std::get_if<ConfigValue::List>(&value->content);
    if (!list) shared_->refuse(full, "must be a list of texts");
    out.clear();
    for (const ConfigValue& element : *list) {
      const auto* text = std::get_if<std::string>(&element.content);
      if (!text) shared_->refuse(full, "must be a list of texts");
      out.push_back(*text);
    }
  }
  shared_->in_force[full] = list_to_toml(out);
  return out;
}

std::vector<double> Section::numbers(std::string_view key, const std::vector<double>& otherwise, Range range) const {
  const std::string full = join_key(path_, key);
  std::vector<double> out = otherwise;
  if (const ConfigValue* value = shared_->find(full, "a list of numbers")) {
    const auto* list = std::get_if<ConfigValue::List>(&value->content);
    if (!list) shared_->refuse(full, "must be a list of numbers");
    out.clear();
    for (const ConfigValue& element : *list) {
      const auto number = as_number(element);
      if (!number) shared_->refuse(full, "must be a list of numbers");
      if (const std::string why = number_complaint(*number, range); !why.empty())
        shared_->refuse(full, fmt::format("each {}", why));
      out.push_back(*number);
    }
  }
  shared_->in_force[full] = list_to_toml(out);
  return out;
}

std::string Section::required_text(std::string_view key) const {
  const std::string full = join_key(path_, key);
  if (!shared_->find(full, "a text")) {
    const ConfigOrigin* table = shared_->origin(path_);
    throw ConfigError(
        fmt::format("{}: {} is missing; it must be a text", table ? table->place() : shared_->file.string(), full));
  }
  return text(key, "");
}

fs::path Section::path(std::string_view key, std::string_view otherwise) const {
  const std::string written = text(key, otherwise);
  if (written.empty()) return {};
  if (written.find('\0') != std::string::npos) refuse(key, "must be a path");
  const std::string full = join_key(path_, key);
  const auto value = shared_->tree.values.find(full);
  const fs::path folder =
      value == shared_->tree.values.end() ? shared_->file.parent_path() : value->second.origin.folder;
  const fs::path out = (folder / written).lexically_normal();
  shared_->in_force[full] = to_toml(fs::absolute(out).lexically_normal().string());
  return out;
}

Section Section::section(std::string_view key) const {
  const std::string full = join_key(path_, key);
  shared_->tables.insert(full);
  if (shared_->tree.values.contains(full)) refuse(key, "must be a table");
  if (shared_->tree.arrays.contains(full)) refuse(key, fmt::format("must be a single table, [{}]", full));
  return Section(shared_, full);
}

std::vector<Section> Section::sections(std::string_view key) const {
  const std::string full = join_key(path_, key);
  shared_->tables.insert(full);
  std::vector<Section> out;
  if (const auto it = shared_->tree.arrays.find(full); it != shared_->tree.arrays.end()) {
    for (std::size_t i = 0; i < it->second.size; ++i) {
      out.push_back(Section(shared_, fmt::format("{}[{}]", full, i)));
      shared_->tables.insert(out.back().path_);
    }
    return out;
  }
  // an empty list is an array without tables
  const auto value = shared_->tree.values.find(full);
  const auto* list =
      value == shared_->tree.values.end() ? nullptr : std::get_if<ConfigValue::List>(&value->second.content);
  if (list && list->empty())
    shared_->keys.insert(full);
  else if (shared_->origin(full))
    refuse(key, fmt::format("must be a list of tables, each beginning with [[{}]]", full));
  return out;
}

std::vector<std::string> Section::names_below(std::string_view key) const {
  const std::string full = section(key).path_;
  shared_->listed.insert(full);
  // tables are sorted by key, so that equal names are neighbours; deeper ones and their own table give the same name
  std::set<std::string> names;
  const std::string prefix = full + ".";
  const auto& tables = shared_->tree.tables;
  for (auto it = tables.lower_bound(prefix); it != tables.end() && it->first.starts_with(prefix); ++it) {
    const std::vector<ConfigStep> steps = split_key(std::string_view(it->first).substr(prefix.size()));
    if (steps.size() == 1 && steps.front().index < 0) names.insert(steps.front().name);
  }
  return {names.begin(), names.end()};
}

bool Section::has(std::string_view key) const {
  const std::string full = join_key(path_, key);
  const bool there = shared_->origin(full) != nullptr;
  const bool is_value = shared_->tree.values.contains(full);
  if (there && !is_value)
    shared_->tables.insert(full);
  else
    shared_->keys.insert(full);
  if (!there) shared_->absent.insert(full);
  return there;
}

void Section::leave_alone(std::string_view key) const {
  shared_->left_alone.insert(join_key(path_, key));
}

void Section::refuse(std::string_view key, std::string_view sentence) const {
  shared_->refuse(join_key(path_, key), sentence);
}

}  // namespace arkmesh::hal
