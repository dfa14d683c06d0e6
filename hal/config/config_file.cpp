// Reads TOML files and lays them over each other by moving nodes, which keep the places where they were written. Sizes,
// nesting and the number of files are limited before toml++ sees anything: it recurses.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <sstream>
#include <utility>

#include "hal/config/config_state.hpp"

namespace arkmesh::hal {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t max_file_bytes = 1 << 20;
constexpr std::size_t max_files = 64;  // included ones, counted each time they are included
constexpr int max_dots = 32;           // of a key: each is a table within a table

[[noreturn]] void fail(std::string_view place, std::string_view sentence) {
  throw ConfigError(fmt::format("{}: {}", place, sentence));
}

// Whether some key has very many dots. What looks like a key in a text of several lines counts too.
bool has_deep_key(std::string_view text) {
  int dots = 0;
  char quote = 0, before = 0;
  for (std::size_t i = 0; i < text.size(); before = text[i++]) {
    const char c = text[i];
    if (c == '\n') quote = 0;
    if (quote != 0) {
      if (c == '\\' && quote == '"' && i + 1 < text.size()) ++i;
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '.') {
      dots += before == '.' ? 0 : 1;
    } else if (std::string_view("=,[]{}\n").find(c) != std::string_view::npos) {
      dots = 0;
    }
    if (dots > max_dots) return true;
  }
  return false;
}

toml::table parse(std::string_view text, const std::string& source) {
  if (has_deep_key(text)) fail(source, fmt::format("a key has more than {} dots", max_dots));
  try {
    return toml::parse(text, source);
  } catch (const toml::parse_error& error) {
    if (const std::string end = fs::path(source).extension();
        !source.starts_with(override_mark) && !end.empty() && end != ".toml")
      fail(source, "is not a configuration file (.toml); give a lab's, such as shark.toml");
    fail(to_text(error.source()), fmt::format("not valid TOML: {}", error.description()));
  } catch (const BrokenAssumption&) {
    fail(source, "not valid TOML; look for stray characters in [table] headers and keys");
  }
}

std::string read_file(const fs::path& file, const std::string& place) {
  const auto refuse = [&](std::string_view sentence) { fail(place, fmt::format("{} {}", file.string(), sentence)); };
  std::error_code ignored;
  const fs::file_status status = fs::status(file, ignored);
  if (!fs::exists(status)) fail(place, fmt::format("there is no file {}", file.string()));
  if (!fs::is_regular_file(status)) refuse("is not a text file");
  std::ifstream in(file, std::ios::binary);
  std::string text(max_file_bytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad() || !in.is_open()) refuse("cannot be read; check its permissions");
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > max_file_bytes) refuse("is larger than 1 MiB; is it a configuration file?");
  return text;
}

// Moves all of `from` into `into`, table by table. Where both have something else, `from` wins or not.
void merge(toml::table& into, toml::table&& from, bool wins) {
  for (auto&& [key, node] : from) {
    toml::node* const there = into.get(key);
    if (there && there->is_table() && node.is_table())
      merge(*there->as_table(), std::move(*node.as_table()), wins);
    else if (!there || wins)
      into.insert_or_assign(key, std::move(node));
  }
}

class Loader {
 public:
  // `place` asked for the file: where a message about its absence points.
  toml::table load(const fs::path& file, const std::string& place) {
    const fs::path identity = fs::weakly_canonical(file);
    if (std::ranges::find(open_, identity) != open_.end())
      fail(place, fmt::format("{} includes itself; remove one of the includes", file.string()));
    read_.push_back(file);
    if (read_.size() > max_files) fail(place, fmt::format("more than {} files included", max_files));
    open_.push_back(identity);
    toml::table out = from_text(read_file(file, place), file);
    open_.pop_back();
    return out;
  }

  toml::table from_text(std::string_view text, const fs::path& file) {
    toml::table out = parse(text, file.string());
    const toml::node* const include = out.get("include");
    if (!include) return out;
    const std::string place = fmt::format("{}: include = ", to_text(include->source()));
    toml::table below;
    const toml::array* const list = include->as_array();
    for (std::size_t i = 0; list && i < list->size(); ++i) {
      const std::string name = list->get(i)->value_exact<std::string>().value_or("");
      if (name.empty() || name.find('\0') != std::string::npos) fail(place + to_toml(*include), must_be_list);
      merge(below, load((file.parent_path() / name).lexically_normal(), place + to_toml(*list->get(i))), true);
    }
    if (!list) fail(place + to_toml(*include), must_be_list);
    out.erase("include");
    merge(out, std::move(below), false);
    return out;
  }

  const std::vector<fs::path>& read() const { return read_; }

 private:
  static constexpr std::string_view must_be_list = "must be a list of file names, such as [\"common.toml\"]";
  std::vector<fs::path> open_, read_;
};

// "arena.robots=48": sets one key.
void apply_override(toml::table& tree, const std::string& text) {
  const std::string source = std::string(override_mark) + text;
  const std::size_t equals = text.find('='), colon = std::min(text.find(':'), equals);
  if (equals == std::string::npos) fail(source, "must look like key=value, for example arena.robots=48");
  const std::string lab = toml::at_path(tree, "lab.name").value_or(std::string());
  if (colon < equals && text.substr(0, colon) != lab)
    fail(source, fmt::format("is for lab {}, but this file belongs to lab '{}'", text.substr(0, colon), lab));
  const std::string key = text.substr(colon < equals ? colon + 1 : 0, equals - (colon < equals ? colon + 1 : 0));
  std::string written = text.substr(equals + 1);
  written.erase(0, written.find_first_not_of(" \t"));
  try {
    merge(tree, parse(fmt::format("{} = {}", key, written), source), true);
  } catch (const ConfigError&) {
    // a bare word is a text
    if (!written.empty() && std::string_view("\"'[{").find(written.front()) != std::string_view::npos) throw;
    merge(tree, parse(fmt::format("{} = {}", key, to_toml(written)), source), true);
  }
}

// The preset's file; refuses names of none, listing those there are.
fs::path preset_file(const fs::path& presets, const std::string& name, const std::string& place) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(presets, error), end; !error && it != end; it.increment(error))
    if (it->path().extension() == ".toml") names.push_back(it->path().stem().string());
  std::ranges::sort(names);
  if (std::ranges::find(names, name) == names.end())
    fail(place, fmt::format("preset = \"{}\": there is no such preset in {}; there are: {}", name, presets.string(),
                            names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
  return presets / (name + ".toml");
}

}  // namespace

std::string to_text(const toml::source_region& place) {
  if (!place.path || place.path->starts_with(override_mark)) return place.path ? *place.path : std::string();
  return fmt::format("{}:{}", *place.path, place.begin.line);
}

std::string to_toml(const toml::node& node) {
  std::ostringstream out;
  node.visit([&](const auto& known) { out << toml::toml_formatter(known, toml::format_flags::none); });
  std::string text = out.str();
  std::ranges::replace(text, '\n', ' ');
  return text;
}

std::string to_toml(const std::variant<std::string, double>& value) {
  return std::visit([](const auto& known) { return to_toml(static_cast<const toml::node&>(toml::value(known))); },
                    value);
}

Section::State load_config(const fs::path& file, const std::string_view* text,
                           const std::vector<std::string>& overrides) {
  try {
    Loader loader;
    Section::State out{.file = file};
    out.tree = text ? loader.from_text(*text, file) : loader.load(file, file.string());
    // a preset is beside the file that names one, also when an override names another; it lies under all
    const toml::node* preset = out.tree.get("preset");
    const fs::path presets = fs::path(preset ? *preset->source().path : file.string()).parent_path() / "presets";
    for (const std::string& one : overrides) apply_override(out.tree, one);
    preset = out.tree.get("preset");
    out.included = loader.read();
    if (!preset) return out;
    const std::string place = to_text(preset->source());
    if (!preset->is_string()) fail(place, fmt::format("preset = {}: must be a text", to_toml(*preset)));
    out.preset = preset->value_or(std::string());
    out.tree.erase("preset");
    if (out.preset.empty()) return out;
    toml::table lowest = loader.load(preset_file(presets, out.preset, place), place);
    if (const toml::node* nested = lowest.get("preset"))
      fail(to_text(nested->source()), "preset: a preset cannot name another one; use include");
    merge(out.tree, std::move(lowest), false);
    out.included = loader.read();
    return out;
  } catch (const fs::filesystem_error& error) {
    fail(file.string(), error.what());
  }
}

}  // namespace arkmesh::hal
