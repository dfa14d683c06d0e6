// What all sections of one configuration share: the loaded tree, and the books of what was asked for. Internal to
// Config and Section.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "hal/config.hpp"
#include "hal/config_tree.hpp"

namespace arkmesh::hal {

struct Section::Shared {
  std::filesystem::path file;
  std::string preset;
  ConfigTree tree;
  // what was asked for
  std::map<std::string, std::string> in_force;      // key -> value as TOML
  std::set<std::string, std::less<>> keys, tables;  // all asked for, whether there or not
  std::set<std::string, std::less<>> listed;        // tables whose names were asked for
  std::set<std::string, std::less<>> left_alone;    // tables that belong to a choice not made
  std::set<std::string, std::less<>> absent;        // keys that has() said are not there

  const ConfigOrigin* origin(std::string_view key) const {
    if (const auto it = tree.values.find(key); it != tree.values.end()) return &it->second.origin;
    if (const auto it = tree.tables.find(key); it != tree.tables.end()) return &it->second;
    if (const auto it = tree.arrays.find(key); it != tree.arrays.end()) return &it->second.origin;
    return nullptr;
  }

  [[noreturn]] void refuse(const std::string& key, std::string_view sentence) const {
    const ConfigOrigin* where = origin(key);
    const auto value = tree.values.find(key);
    std::string shown;
    if (value != tree.values.end())
      shown = to_toml(value->second);
    else if (const auto it = in_force.find(key); it != in_force.end())
      shown = it->second;
    if (shown.size() > 80) shown = shown.substr(0, 77) + "...";
    throw ConfigError(fmt::format("{}: {}{}{}: {}", where ? where->place() : file.string(), key,
                                  shown.empty() ? "" : " = ", shown, sentence));
  }

  // The value of a key, if the file holds it. `must_be` completes the sentence when a table is there instead.
  const ConfigValue* find(const std::string& key, std::string_view must_be) {
    keys.insert(key);
    if (tree.tables.contains(key) || tree.arrays.contains(key))
      refuse(key, fmt::format("must be {}, not a table", must_be));
    const auto it = tree.values.find(key);
    return it == tree.values.end() ? nullptr : &it->second;
  }

  // Unread keys below a listed table are known when a neighbour's key of that name was read: with
  // names_below("projection") and projection.shark.scale read, projection.lynx.scale is known even if lynx takes no
  // part.
  bool known_beside(std::string_view key) const {
    for (const std::string& list : listed) {
      if (!key.starts_with(list) || key.size() <= list.size() || key[list.size()] != '.') continue;
      const std::string_view own_rest = split_below(list, key).second;
      bool read_any = false;
      for (auto it = keys.lower_bound(list + "."); it != keys.end() && it->starts_with(list + "."); ++it) {
        read_any = true;
        if (split_below(list, *it).second == own_rest) return true;
      }
      if (!read_any) return true;
    }
    return false;
  }

  static std::pair<std::string_view, std::string_view> split_below(std::string_view table, std::string_view key) {
    const std::string_view below = key.substr(table.size() + 1);
    const std::size_t name = split_key(below).front().name.size();
    return {below.substr(0, name), below.substr(name)};
  }

  // What `key` could be if it were read like its neighbours below a listed table.
  void add_beside(const std::string& list, std::string_view key, std::set<std::string, std::less<>>& candidates) const {
    const std::string_view own_name = split_below(list, key).first;
    for (auto it = keys.lower_bound(list + "."); it != keys.end() && it->starts_with(list + "."); ++it)
      candidates.insert(fmt::format("{}.{}{}", list, own_name, split_below(list, *it).second));
  }

  bool is_left_alone(std::string_view key) const {
    return std::any_of(left_alone.begin(), left_alone.end(), [&](const std::string& table) {
      return key.starts_with(table) &&
             (key.size() == table.size() || key[table.size()] == '.' || key[table.size()] == '[');
    });
  }

  // A table is known when it, or anything below it, was asked for.
  bool is_known_table(std::string_view table) const {
    const std::string below = std::string(table) + ".", elements = std::string(table) + "[";
    const auto any_below = [&](const auto& asked) {
      for (const std::string& prefix : {below, elements})
        if (const auto it = asked.lower_bound(prefix); it != asked.end() && it->starts_with(prefix)) return true;
      return false;
    };
    if (tables.contains(table) || any_below(tables) || any_below(keys) || is_left_alone(table)) return true;
    return std::any_of(listed.begin(), listed.end(),
                       [&](const std::string& list) { return table.starts_with(list + "."); });
  }
};

}  // namespace arkmesh::hal
