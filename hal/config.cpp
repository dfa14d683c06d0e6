// Loading, unknown keys, and the effective configuration. Reading keys: config_section.cpp.
#include "hal/config.hpp"

#include <fmt/format.h>

#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "hal/config_file.hpp"
#include "hal/config_shared.hpp"
#include "hal/near_key.hpp"

namespace arkmesh::hal {

namespace fs = std::filesystem;

Config Config::from_file(const fs::path& file, const std::vector<std::string>& overrides) {
  Config out;
  out.shared_ = std::make_shared<Section::Shared>();
  out.shared_->file = file;
  auto [tree, preset] = load_config(file, nullptr, overrides);
  out.shared_->tree = std::move(tree);
  out.shared_->preset = std::move(preset);
  return out;
}

Config Config::from_text(std::string_view text, std::string_view name, const std::vector<std::string>& overrides) {
  Config out;
  out.shared_ = std::make_shared<Section::Shared>();
  out.shared_->file = name;
  auto [tree, preset] = load_config(out.shared_->file, &text, overrides);
  out.shared_->tree = std::move(tree);
  out.shared_->preset = std::move(preset);
  return out;
}

Section Config::root() const {
  return Section(shared_, "");
}

const fs::path& Config::file() const {
  return shared_->file;
}

void Config::refuse_unknown(std::string_view below) const {
  const Section::Shared& shared = *shared_;
  // the first in each file, so that what comes first in the text is named first
  std::optional<std::tuple<std::string, unsigned, std::string>> first;
  bool is_table = false;
  const auto consider = [&](const std::string& key, const ConfigOrigin& origin, bool table) {
    if (!below.empty() && (!key.starts_with(below) || key.find_first_of(".[", below.size()) != below.size())) return;
    std::tuple found{*origin.source, origin.line, key};
    if (!first || found < *first) first = std::move(found), is_table = table;
  };
  for (const auto& [key, value] : shared.tree.values)
    if (!shared.keys.contains(key) && !shared.is_left_alone(key) && !shared.known_beside(key))
      consider(key, value.origin, false);
  for (const auto& [key, origin] : shared.tree.tables)
    if (!shared.is_known_table(key)) consider(key, origin, true);
  for (const auto& [key, array] : shared.tree.arrays)
    if (!shared.is_known_table(key)) consider(key, array.origin, true);
  if (!first) return;

  const std::string& key = std::get<2>(*first);
  auto candidates = is_table ? shared.tables : shared.keys;
  for (const std::string& list : shared.listed)
    if (key.starts_with(list + ".")) shared.add_beside(list, key, candidates);
  const auto near = near_key(key, candidates);
  throw ConfigError(fmt::format("{}: unknown {} '{}'; {}", shared.origin(key)->place(), is_table ? "table" : "key", key,
                                near ? fmt::format("did you mean '{}'?", *near) : "remove it or correct its name"));
}

namespace {

// The effective configuration on its way to text.
struct Written {
  std::map<std::string, std::string> values;
  std::map<std::string, Written> tables;
  std::map<std::string, std::map<int, Written>> arrays;

  Written& at(const std::vector<ConfigStep>& steps, std::size_t count) {
    Written* out = this;
    for (std::size_t i = 0; i < count; ++i)
      out = steps[i].index < 0 ? &out->tables[steps[i].name] : &out->arrays[steps[i].name][steps[i].index];
    return *out;
  }

  void print(std::string& out, const std::string& path) const {
    for (const auto& [key, value] : values) out += fmt::format("{} = {}\n", key, value);
    for (const auto& [name, table] : tables) {
      const std::string full = join_key(path, name);
      if (!table.values.empty() || (table.tables.empty() && table.arrays.empty())) out += fmt::format("\n[{}]\n", full);
      table.print(out, full);
    }
    for (const auto& [name, elements] : arrays) {
      const std::string full = join_key(path, name);
      for (const auto& [index, table] : elements) {
        out += fmt::format("\n[[{}]]\n", full);
        table.print(out, full);
      }
    }
  }
};

}  // namespace

std::string Config::effective() const {
  const Section::Shared& shared = *shared_;
  Written root;
  const auto write = [&](const std::string& key, const std::string& value) {
    const std::vector<ConfigStep> steps = split_key(key);
    root.at(steps, steps.size() - 1).values[steps.back().name] = value;
  };
  // tables that were asked for and are there, even if nothing was read from them
  for (const auto& [key, origin] : shared.tree.tables) {
    const std::vector<ConfigStep> steps = split_key(key);
    if (shared.is_known_table(key) && !shared.is_left_alone(key)) root.at(steps, steps.size());
  }
  for (const auto& [key, value] : shared.tree.values)
    if (!shared.keys.contains(key) && !shared.is_left_alone(key) && shared.known_beside(key))
      write(key, to_toml(value));
  for (const auto& [key, value] : shared.in_force)
    if (!shared.absent.contains(key)) write(key, value);

  std::string out = fmt::format("# The effective configuration of {}", to_toml(shared.file.string()));
  if (!shared.preset.empty()) out += fmt::format(" with preset {}", to_toml(shared.preset));
  out += ".\n";
  root.print(out, "");
  return out;
}

std::map<std::string, std::string> Config::in_force_below(std::string_view prefix) const {
  std::map<std::string, std::string> out;
  const std::string below = std::string(prefix) + ".";
  for (auto it = shared_->in_force.lower_bound(below); it != shared_->in_force.end() && it->first.starts_with(below);
       ++it)
    out.insert(*it);
  return out;
}

}  // namespace arkmesh::hal
