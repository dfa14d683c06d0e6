#include "hal/config/config_entries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "hal/config/config_state.hpp"

namespace arkmesh::hal {
namespace {

ConfigEntry::Value value_of(const toml::node& node) {
  const std::string toml = to_toml(node);
  return {.toml = toml, .text = node.value_exact<std::string>().value_or(toml), .is_text = node.is_string()};
}

class Collector {
 public:
  explicit Collector(const std::vector<std::filesystem::path>& files) : files_(files) {}

  void collect(const toml::table& table, const std::vector<std::string>& path) {
    for (const auto& [key, node] : table) {
      std::vector<std::string> at = path;
      at.emplace_back(key.str());
      if (node.is_table() && !node.as_table()->empty())
        collect(*node.as_table(), at);
      else if (path.empty() && node.is_array_of_tables())
        for (std::size_t i = 0; i < node.as_array()->size(); ++i) {
          std::vector<std::string> element = at;
          element.push_back(std::to_string(i));
          collect(*node.as_array()->get(i)->as_table(), element);
        }
      else
        add(node, at);
    }
  }

  std::vector<ConfigEntry> in_order() {
    std::ranges::stable_sort(found_, {}, &Found::at);
    std::vector<ConfigEntry> out;
    for (Found& found : found_) out.push_back(std::move(found.entry));
    return out;
  }

 private:
  struct Found {
    std::tuple<std::ptrdiff_t, unsigned, unsigned> at;  // file, line, column
    ConfigEntry entry;
  };

  void add(const toml::node& node, const std::vector<std::string>& path) {
    const toml::source_region& source = node.source();
    ConfigEntry entry{.path = path, .value = value_of(node), .place = to_text(source)};
    entry.is_table = node.is_table();
    entry.is_list = node.is_array();
    for (std::size_t i = 0; entry.is_list && i < node.as_array()->size(); ++i)
      entry.elements.push_back(value_of(*node.as_array()->get(i)));
    const auto file = std::ranges::find(files_, std::filesystem::path(source.path ? *source.path : ""));
    found_.push_back({{file - files_.begin(), source.begin.line, source.begin.column}, std::move(entry)});
  }

  const std::vector<std::filesystem::path>& files_;
  std::vector<Found> found_;
};

}  // namespace

ConfigEntries read_entries(const std::filesystem::path& file) {
  const Section::State state = load_config(file, nullptr, {});
  Collector collector(state.included);
  collector.collect(state.tree, {});
  return {collector.in_order(), state.included};
}

}  // namespace arkmesh::hal
