// Fills structs from what the files say, notes what is in force, and finds what nobody read.
#include "hal/config/config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <tuple>
#include <utility>

#include "hal/config/config_state.hpp"
#include "hal/config/near_key.hpp"
#include "hal/config/without_secrets.hpp"
#include "hal/files/own_files.hpp"

namespace arkmesh::hal {

namespace fs = std::filesystem;

namespace {

template <class T>
bool take(const toml::node& node, T& out) {
  const std::optional<T> value = node.value_exact<T>();
  if (value) out = *value;
  return value.has_value();
}
bool take(const toml::node& node, double& out) {
  if (node.is_number()) out = *node.value<double>();
  return node.is_number();
}
bool take(const toml::node& node, fs::path& out) {
  std::string text;
  if (!take(node, text) || text.find('\0') != std::string::npos) return false;
  out = text;
  return true;
}
template <class T>
bool take(const toml::node& node, std::vector<T>& out) {
  out.clear();
  if constexpr (std::is_same_v<T, fs::path>)
    if (node.is_string()) return take(node, out.emplace_back());
  const toml::array* const list = node.as_array();
  for (std::size_t i = 0; list && i < list->size(); ++i)
    if (!take(*list->get(i), out.emplace_back())) return false;
  return list != nullptr;
}

// Notes a member's value as that of a key. A number that is not given is not noted.
void put(toml::table& table, std::string_view key, const Section::Member& member) {
  std::visit(
      [&](const auto* value) {
        using T = std::decay_t<decltype(*value)>;
        if constexpr (std::is_same_v<T, fs::path>) {
          table.insert_or_assign(key, value->string());
        } else if constexpr (std::is_same_v<T, std::vector<fs::path>>) {
          if (value->size() == 1) return void(table.insert_or_assign(key, value->front().string()));
          toml::array list;
          for (const fs::path& path : *value) list.push_back(path.string());
          table.insert_or_assign(key, std::move(list));
        } else if constexpr (std::ranges::range<T> && !std::is_same_v<T, std::string>) {
          toml::array list;
          for (const auto& element : *value) list.push_back(element);
          table.insert_or_assign(key, std::move(list));
        } else if (*value == *value) {
          table.insert_or_assign(key, *value);
        }
      },
      member);
}

// What a member must be, in the order of Section::Member, and what the table of keys calls it.
constexpr std::string_view kinds[] = {"true or false",     "a whole number",  "a number",
                                      "a text in quotes",  "a path",          "a list of whole numbers",
                                      "a list of numbers", "a list of texts", "a path, or a list of paths"};

// A path as it stands in a file, or in an override.
fs::path resolved(const fs::path& written, const toml::source_region& place) {
  const std::string text = written.string();
  if (text.starts_with(own_mark)) {
    const std::string own = text.substr(own_mark.size());
    return own_file(own, own);
  }
  const bool in_file = place.path && !place.path->starts_with(override_mark);
  const fs::path folder = in_file ? fs::path(*place.path).parent_path() : fs::current_path();
  const fs::path named = fs::absolute(folder / written).lexically_normal();
  // What ".." leads out of may be a link.
  std::error_code error;
  const fs::path followed = (fs::weakly_canonical(folder, error) / written).lexically_normal();
  return fs::exists(named, error) || !fs::exists(followed, error) ? named : followed;
}

}  // namespace

std::string join(std::string_view table, std::string_view key) {
  return table.empty() || key.empty() ? fmt::format("{}{}", table, key) : fmt::format("{}.{}", table, key);
}

Section Section::section(std::string_view key, int element) const {
  const std::string path = join(path_, key);
  return Section(state_, element < 0 ? path : fmt::format("{}[{}]", path, element));
}

void Section::leave_alone(std::string_view key) const {
  state_->left_alone.insert(join(path_, key));
}

void Section::take_up(std::string_view key) const {
  state_->left_alone.erase(join(path_, key));
}

void Section::refuse(std::string_view key, std::string_view sentence) const {
  const std::string full = join(path_, key);
  const toml::node* const node = toml::at_path(state_->tree, full).node();
  std::string shown = node && !node->is_table() ? " = " + without_secrets(to_toml(*node)) : "";
  if (shown.size() > 80) shown = shown.substr(0, 77) + "...";
  throw ConfigError(fmt::format("{}: {}{}: {}", to_text(state_->place(full)), full, shown, sentence));
}

std::string Section::place(std::string_view key) const {
  const toml::source_region where = state_->place(join(path_, key)), of_table = state_->place(path_);
  return where.begin == of_table.begin && where.path == of_table.path ? "" : to_text(where);
}

void Section::visit(const std::function<void(const Section&)>& fields) const {
  state_->is_filling = true;
  fields(*this);
  // once more: a check may have filled in what other keys give
  state_->is_filling = false;
  fields(*this);
}

bool Section::is_filling() const {
  return state_->is_filling;
}

// The table itself, made when the files have none.
toml::table& Section::State::table(const Section& section) {
  toml::table* table = &tree;
  const std::string& path = section.path_;
  for (std::size_t begin = 0, end = 0; begin < path.size(); begin = end + 1) {
    end = std::min(path.find('.', begin), path.size());
    const std::string step = path.substr(begin, end - begin), so_far = path.substr(0, end);
    toml::node* next = toml::at_path(*table, step).node();
    if (next && !next->is_table())
      section.refuse("", next->is_array() ? fmt::format("must be a single table, [{}]", so_far) : "must be a table");
    const toml::source_region where = place(so_far);
    if (!next) next = &table->insert_or_assign(step, toml::table()).first->second;
    read.try_emplace(next, Read{where});
    table = next->as_table();
  }
  return *table;
}

// Where a key is written; one that is not there, where its table begins.
toml::source_region Section::State::place(std::string key) const {
  const toml::node* node = nullptr;
  while (!node && !key.empty()) {
    node = toml::at_path(tree, key).node();
    const std::size_t cut = key.find_last_of(".[");
    key.resize(cut == std::string::npos ? 0 : cut);
  }
  const auto found = read.find(node);
  return found != read.end() ? found->second.place : node ? node->source() : tree.source();
}

void Section::value(std::string_view key, Member member, const Field& about) const {
  State& state = *state_;
  const std::string_view kind = kinds[member.index()];
  if (state.listed) {
    toml::table one;
    put(one, key, member);
    const std::string value = one.empty() ? "" : to_toml(*one.get(key));
    state.listed->push_back({path_, std::string(key), std::string(kind), value, about});
    return;
  }
  toml::table& table = state.table(*this);
  const toml::node* const said = table.get(key);
  const toml::source_region place = state.place(join(path_, key));
  auto* const* const path = std::get_if<fs::path*>(&member);
  auto* const* const paths = std::get_if<std::vector<fs::path>*>(&member);
  if (state.is_filling && !said && about.required)
    refuse(key,
           fmt::format("is missing; it must be {}{}{}", kind, about.sample.empty() ? "" : ", such as ", about.sample));
  if (state.is_filling && said) {
    if (!std::visit([&](auto* out) { return take(*said, *out); }, member))
      refuse(key, fmt::format("must be {}{}", kind, said->is_table() ? ", not a table" : ""));
    if (path && !(*path)->empty()) **path = resolved(**path, place);
    if (paths && said->is_string() && (*paths)->front().empty()) (*paths)->clear();
    if (paths)
      for (fs::path& each : **paths) {
        if (each.empty()) refuse(key, "must not contain an empty path");
        each = resolved(each, place);
      }
    check_value(key, member, about);
    const auto* const text = std::get_if<std::string*>(&member);
    if (about.required && ((path && (*path)->empty()) || (paths && (*paths)->empty()) || (text && (*text)->empty())))
      refuse(key,
             fmt::format("must not be empty{}{}", about.sample.empty() ? "" : "; write one such as ", about.sample));
  }
  state.read.erase(said);
  put(table, key, member);
  if (const toml::node* now = table.get(key))
    state.read[now] = {place, path || paths, about.written};
  else
    state.left_alone.insert(join(path_, key));  // not given, but known
}

void Section::check_value(std::string_view key, const Member& member, const Field& about) const {
  const auto check = [&](double number, std::string_view each) {
    const auto [low, high] = about.range;
    if (!std::isfinite(number)) refuse(key, fmt::format("{}must be a finite number", each));
    if (number >= low && number <= high) return;
    refuse(key, std::isinf(high)  ? fmt::format("{}must be at least {}", each, low)
                : std::isinf(low) ? fmt::format("{}must be at most {}", each, high)
                                  : fmt::format("{}must be between {} and {}", each, low, high));
  };
  if (const auto* number = std::get_if<double*>(&member)) check(**number, "");
  if (const auto* number = std::get_if<std::int64_t*>(&member)) check(static_cast<double>(**number), "");
  if (const auto* list = std::get_if<std::vector<double>*>(&member))
    for (const double number : **list) check(number, "each ");
  if (const auto* list = std::get_if<std::vector<std::int64_t>*>(&member))
    for (const std::int64_t number : **list) check(static_cast<double>(number), "each ");
  const auto* const text = std::get_if<std::string*>(&member);
  if (!text || about.one_of.empty() || std::ranges::find(about.one_of, **text) != about.one_of.end()) return;
  refuse(key, fmt::format("must be one of \"{}\"", fmt::join(about.one_of, "\", \"")));
}

void Section::seconds(std::string_view key, std::chrono::microseconds& member, const Field& about) const {
  double seconds = static_cast<double>(member.count()) / 1e6;
  value(key, &seconds, about);
  if (std::abs(seconds * 1e6 - std::round(seconds * 1e6)) > 1e-3) refuse(key, "must be a whole number of microseconds");
  member = std::chrono::microseconds(std::llround(seconds * 1e6));
}

std::size_t Section::elements(std::string_view key, std::size_t have) const {
  if (state_->listed) return 1;
  toml::table& table = state_->table(*this);
  const toml::node* list = table.get(key);
  if (!list) list = &table.insert_or_assign(key, toml::array()).first->second;
  if (!list->is_array() || (!list->as_array()->empty() && !list->is_array_of_tables()))
    refuse(key, fmt::format("must be a list of tables, each beginning with [[{}]]", join(path_, key)));
  state_->read.try_emplace(list, State::Read{state_->place(join(path_, key))});
  return is_filling() ? list->as_array()->size() : have;
}

std::vector<std::string> Section::names(std::vector<std::string> have) const {
  if (state_->listed) return {"<lab>"};
  if (!is_filling()) return have;
  for (const auto& [name, node] : state_->table(*this)) {
    if (name.str().find_first_of(".[") != std::string_view::npos)
      refuse("", fmt::format("'{}' is not a valid name; use letters, digits, '_' and '-'", name.str()));
    if (std::ranges::find(have, name.str()) == have.end()) have.emplace_back(name.str());
  }
  return have;
}

std::vector<KeyRow> list_keys(const std::string& table, const std::function<void(const Section&)>& fields) {
  std::vector<KeyRow> rows;
  const auto state = std::make_shared<Section::State>();
  state->listed = &rows;
  fields(Section(state, table));
  return rows;
}

Config::Config(const fs::path& file, const std::string_view* text, const std::vector<std::string>& overrides)
    : state_(std::make_shared<Section::State>(load_config(file, text, overrides))) {}

Config Config::from_file(const fs::path& file, const std::vector<std::string>& overrides) {
  Config config(file, nullptr, overrides);
  if (const toml::table& tree = config.state_->tree; tree.contains("labs") && !tree.contains("lab"))
    throw ConfigError(
        fmt::format("{} is an experiment; run it with arkmesh batch, or give one of its labs' files", file.string()));
  return config;
}

Config Config::from_text(std::string_view text, std::string_view name, const std::vector<std::string>& overrides) {
  return Config(name, &text, overrides);
}

const fs::path& Config::file() const {
  return state_->file;
}

std::vector<std::string> Config::files() const {
  std::vector<std::string> names;
  for (const fs::path& file : state_->included)
    names.push_back(file.lexically_relative(state_->file.parent_path()).string());
  return names;
}

void Config::refuse_unknown(std::string_view below) const {
  // What comes first in the text is named first. The node is kept: a quoted key may hold a dot, so its name is no path
  // to it.
  std::map<std::tuple<std::string, unsigned, std::string>, const toml::node*> unknown;
  std::set<std::string, std::less<>> known = state_->left_alone;
  for_each(state_->tree, "", [&](const std::string& key, const toml::node& node) {
    const bool is_read = state_->read.contains(&node);
    if (is_read) known.insert(key);
    const bool counts =
        below.empty() || (key.starts_with(below) &&
                          (key.size() == below.size() || key[below.size()] == '.' || key[below.size()] == '['));
    const bool is_left_alone = state_->left_alone.contains(key);
    if (!is_read && counts && !is_left_alone)
      unknown.emplace(std::tuple(*node.source().path, node.source().begin.line, key), &node);
    return is_read && !is_left_alone;
  });
  if (unknown.empty()) return;
  const std::string& key = std::get<2>(unknown.begin()->first);
  const toml::node* node = unknown.begin()->second;
  const auto near = near_key(key, known);
  throw ConfigError(fmt::format("{}: unknown {} '{}'; {}", to_text(node->source()), node->is_value() ? "key" : "table",
                                key,
                                near ? fmt::format("did you mean '{}'?", *near) : "remove it or correct its name"));
}

std::vector<fs::path> Config::paths() const {
  std::vector<fs::path> out;
  for (const auto& [node, read] : state_->read) {
    if (!read.is_path) continue;
    if (node->is_string()) out.emplace_back(node->value_or(std::string()));
    for (std::size_t i = 0; node->is_array() && i < node->as_array()->size(); ++i)
      out.emplace_back(node->as_array()->get(i)->value_or(std::string()));
  }
  std::ranges::sort(out);
  return out;
}

}  // namespace arkmesh::hal
