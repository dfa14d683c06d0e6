// What is in force of a configuration, as a file or key by key.
#include <fmt/format.h>

#include <sstream>
#include <utility>

#include "hal/config/config_state.hpp"
#include "hal/files/own_files.hpp"

namespace arkmesh::hal {

namespace fs = std::filesystem;

namespace {

// How a run's config.toml in `folder` names a file, so that it is found when the folder is moved; without a folder, so
// that labs at different places name it alike.
std::string portable(const fs::path& path, const fs::path* folder, const Config::Kept& kept) {
  if (const auto here = kept.find(path); here != kept.end()) return here->second.string();
  const fs::path here = fs::current_path();
  for (const char* folder_of_ours : {"experiments", "scenarios", "sim_ode"}) {
    const fs::path own = path.lexically_relative(own_file(folder_of_ours, folder_of_ours).parent_path());
    if (!own.empty() && *own.begin() == folder_of_ours) return std::string(own_mark) + own.string();
  }
  if (!folder) return path.filename().string();
  if (folder->empty()) return path.string();
  const fs::path from = fs::absolute(*folder).lexically_normal();
  const auto is_below_here = [&](const fs::path& p) { return *p.lexically_relative(here).begin() != ".."; };
  return is_below_here(from) && is_below_here(path) ? path.lexically_relative(from).string() : path.string();
}

// What was read of a table.
toml::table in_force(const Section::State& state, const toml::table& table, const fs::path* folder,
                     const Config::Kept& kept = {}) {
  toml::table out;
  for (const auto& [key, node] : table) {
    const auto read = state.read.find(&node);
    if (read == state.read.end()) continue;
    if (node.is_table()) {
      out.insert(key, in_force(state, *node.as_table(), folder, kept));
    } else if (node.is_array_of_tables()) {
      toml::array list;
      for (const toml::node& element : *node.as_array())
        list.push_back(in_force(state, *element.as_table(), folder, kept));
      out.insert(key, std::move(list));
    } else if (const std::string path = node.value_or(std::string()); read->second.is_path && !path.empty()) {
      out.insert(key, portable(path, folder, kept));
    } else if (read->second.is_path && node.is_array()) {
      toml::array list;
      for (const toml::node& element : *node.as_array())
        list.push_back(portable(element.value_or(std::string()), folder, kept));
      out.insert(key, std::move(list));
    } else if (read->second.written && node.is_string()) {
      out.insert(key, read->second.written(node.value_or(std::string())));
    } else {
      out.insert(key, node);
    }
  }
  return out;
}

}  // namespace

void for_each(const toml::table& table, const std::string& path,
              const std::function<bool(const std::string&, const toml::node&)>& goes_on_below) {
  for (const auto& [key, node] : table) {
    const std::string full = join(path, key.str());
    if (!goes_on_below(full, node)) continue;
    if (node.is_table()) for_each(*node.as_table(), full, goes_on_below);
    for (std::size_t i = 0; node.is_array_of_tables() && i < node.as_array()->size(); ++i)
      for_each(*node.as_array()->get(i)->as_table(), fmt::format("{}[{}]", full, i), goes_on_below);
  }
}

std::string Config::effective(const fs::path& folder, const Kept& kept) const {
  std::ostringstream out;
  out << "# The effective configuration of " << to_toml(state_->file.string());
  if (!state_->preset.empty()) out << " with preset " << to_toml(state_->preset);
  out << ".\n"
      << toml::toml_formatter(in_force(*state_, state_->tree, &folder, kept), toml::format_flags::none) << "\n";
  return out.str();
}

std::map<std::string, std::string, std::less<>> Config::in_force_below(std::string_view table) const {
  std::map<std::string, std::string, std::less<>> out;
  const toml::table* from = &state_->tree;
  if (!table.empty()) {
    const toml::node* const node = from->get(table);
    if (!node || !node->is_table() || !state_->read.contains(node)) return out;
    from = node->as_table();
  }
  for_each(in_force(*state_, *from, nullptr), std::string(table), [&](const std::string& key, const toml::node& node) {
    if (!node.is_table() && !node.is_array_of_tables()) out.emplace(key, to_toml(node));
    return true;
  });
  return out;
}

}  // namespace arkmesh::hal
