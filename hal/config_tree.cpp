// The flat tree and its TOML notation.
#include "hal/config_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

namespace arkmesh::hal {

std::string ConfigOrigin::place() const {
  const std::string_view name = source ? std::string_view(*source) : std::string_view();
  return line > 0 ? fmt::format("{}:{}", name, line) : std::string(name);
}

std::string to_toml(std::string_view text) {
  std::string out = "\"";
  for (char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      out += {'\\', c};
    else if (c == '\n')
      out += "\\n";
    else if (c == '\t')
      out += "\\t";
    else if (byte < 0x20 || byte == 0x7f)
      out += fmt::format("\\u{:04X}", byte);
    else
      out += c;
  }
  return out + '"';
}

std::string to_toml(double number) {
  std::string out = fmt::format("{}", number);
  if (out.find_first_of(".en") == std::string::npos) out += ".0";
  return out;
}

std::string to_toml(const ConfigValue& value) {
  struct Writer {
    std::string operator()(const std::string& text) const { return to_toml(text); }
    std::string operator()(std::int64_t number) const { return fmt::format("{}", number); }
    std::string operator()(double number) const { return to_toml(number); }
    std::string operator()(bool flag) const { return flag ? "true" : "false"; }
    std::string operator()(const ConfigValue::List& list) const {
      std::string out = "[";
      for (const ConfigValue& element : list) out += (out.size() > 1 ? ", " : "") + to_toml(element);
      return out + "]";
    }
    std::string operator()(const ConfigOther& other) const { return other.toml; }
  };
  return std::visit(Writer{}, value.content);
}

std::string to_toml_key(std::string_view key) {
  const auto bare = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  return !key.empty() && std::all_of(key.begin(), key.end(), bare) ? std::string(key) : to_toml(key);
}

std::vector<ConfigStep> split_key(std::string_view dotted) {
  std::vector<ConfigStep> out;
  for (std::size_t at = 0; at <= dotted.size();) {
    // the end of this step: a dot that is not inside quotes
    std::size_t end = at;
    bool quoted = false;
    for (; end < dotted.size() && (quoted || dotted[end] != '.'); ++end) {
      if (quoted && dotted[end] == '\\')
        ++end;
      else if (dotted[end] == '"')
        quoted = !quoted;
    }
    end = std::min(end, dotted.size());
    ConfigStep step{std::string(dotted.substr(at, end - at))};
    // "peers[3]"
    if (const std::size_t open = step.name.rfind('['); open != std::string::npos && step.name.ends_with(']')) {
      int index = -1;
      const char *first = step.name.data() + open + 1, *last = step.name.data() + step.name.size() - 1;
      if (const auto [stop, error] = std::from_chars(first, last, index);
          error == std::errc{} && stop == last && index >= 0) {
        step.index = index;
        step.name.resize(open);
      }
    }
    out.push_back(std::move(step));
    at = end + 1;
  }
  return out;
}

std::string join_key(std::string_view table, std::string_view key) {
  return table.empty() ? std::string(key) : fmt::format("{}.{}", table, key);
}

// Erases the key and all below it.
void ConfigTree::clear(std::string_view key) {
  const auto clear_in = [&](auto& map) {
    if (const auto it = map.find(key); it != map.end()) map.erase(it);
    for (const char separator : {'.', '['}) {
      const std::string prefix = std::string(key) + separator;
      auto it = map.lower_bound(prefix);
      while (it != map.end() && it->first.starts_with(prefix)) it = map.erase(it);
    }
  };
  clear_in(values);
  clear_in(tables);
  clear_in(arrays);
}

void ConfigTree::set_value(const std::string& key, ConfigValue value) {
  clear(key);
  values.emplace(key, std::move(value));
}

void ConfigTree::open_table(const std::string& key, const ConfigOrigin& origin) {
  if (values.contains(key) || arrays.contains(key)) clear(key);
  tables.insert_or_assign(key, origin);
}

void ConfigTree::set_array(const std::string& key, Array array) {
  clear(key);
  arrays.emplace(key, std::move(array));
}

void ConfigTree::lay_over(const ConfigTree& upper) {
  // arrays first: replacing one clears the tables of its elements; then tables, so that every value's table is there
  for (const auto& [key, array] : upper.arrays) set_array(key, array);
  for (const auto& [key, origin] : upper.tables) open_table(key, origin);
  for (const auto& [key, value] : upper.values) set_value(key, value);
}

}  // namespace arkmesh::hal
