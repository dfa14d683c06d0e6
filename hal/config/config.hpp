// Strict configuration: TOML files, laid over each other, fill plain structs that tell their keys once for everybody:
//   struct Run {
//     double duration_s = 1800;  // a member's initializer is the key's default
//     void fields(const hal::Section& s) {
//       s.field("duration_s", duration_s, {.range = {1e-3, 1e7}, .unit = "s", .help = "how long the run lasts"});
//     }
//     void check(const hal::Section& s);  // optional: what one range cannot say; may fill in what other keys give
//   };
// The same visit reads, notes what is in force, and lists the keys. An unknown or ill-typed key is an error.
#pragma once

#include <algorithm>
#include <chrono>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace arkmesh::hal {

// One sentence: file:line: key = value: what is wrong and what to do.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Allowed range of a number, bounds included.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

// What is said of a key beside its name and its member.
struct Field {
  Range range = {};  // of a number, or of each number of a list
  std::string unit = {}, help = {};
  std::vector<std::string> one_of = {};  // the only texts allowed; of an enumeration the names of 0, 1, 2...
  std::string sample = {};               // TOML: a value with which a sample runs, for what has no default
  std::string default_is = {};           // the default in words, when other keys give it
  bool required = false;
  // Of a text that not everybody may read: what a run's config.toml holds instead.
  std::string (*written)(std::string_view text) = nullptr;
};

// A line of the table of keys.
struct KeyRow {
  std::string table, key, type, default_value;
  Field about;
  bool in_use = true;  // by a sample
};

class Section;
template <class T>
concept HasFields = requires(T t, const Section& s) {
  t.fields(s);
};

// A table, by dotted path ("gateway.peers[0]"), whether the files hold it or not. Cheap to copy; all copies share what
// the files said and what was read.
class Section {
 public:
  using Member =
      std::variant<bool*, std::int64_t*, double*, std::string*, std::filesystem::path*, std::vector<std::int64_t>*,
                   std::vector<double>*, std::vector<std::string>*, std::vector<std::filesystem::path>*>;
  struct State;  // config_state.hpp

  // Fills a struct whose defaults are those of `value`, and checks it.
  template <HasFields T>
  T read(T value = {}) const {
    visit([&](const Section& s) { s.visit_struct(value); });
    return value;
  }
  // A single key, for who needs no more.
  template <class T>
  T get(std::string_view key, T value, const Field& about = {}) const {
    visit([&](const Section& s) { s.field(key, value, about); });
    return value;
  }
  Section section(std::string_view key, int element = -1) const;
  // Its keys belong to a choice that was not made ([arena.ode] with arena.use = "null"): nobody need read them,
  // and whoever reads some does not answer for the others.
  void leave_alone(std::string_view key) const;
  // The choice is made after all: unknown keys of it count again.
  void take_up(std::string_view key) const;
  // Throws a ConfigError: "file:line: section.key = value: <sentence>".
  [[noreturn]] void refuse(std::string_view key, std::string_view sentence) const;
  // "gateway.peers[0]"
  const std::string& path() const { return path_; }
  // Where a key is written, "shark.toml:12"; empty when it is not.
  std::string place(std::string_view key) const;

  // For fields(): a value, a table (a struct), a list of tables (a vector of structs), or a table whose keys are names
  // of the user's (a map). A time is in seconds. Texts, paths and lists may be empty; a NaN is a number not given. A
  // list of paths may also be written as one path.
  template <class T>
  void field(std::string_view key, T& member, const Field& about = {}) const {
    if constexpr (HasFields<T>) {
      section(key).visit_struct(member);
    } else if constexpr (std::is_enum_v<T>) {
      std::string name = about.one_of.at(static_cast<std::size_t>(member));
      value(key, &name, about);
      member = static_cast<T>(std::ranges::find(about.one_of, name) - about.one_of.begin());
    } else if constexpr (std::same_as<T, std::chrono::microseconds>) {
      seconds(key, member, about);
    } else if constexpr (std::integral<T> && !std::same_as<T, bool> && !std::same_as<T, std::int64_t>) {
      using Limits = std::numeric_limits<T>;
      std::int64_t number = static_cast<std::int64_t>(member);
      Field narrowed = about;
      narrowed.range.low = std::max(about.range.low, static_cast<double>(Limits::min()));
      if (sizeof(T) < 8) narrowed.range.high = std::min(about.range.high, static_cast<double>(Limits::max()));
      value(key, &number, narrowed);
      member = static_cast<T>(number);
    } else {
      value(key, &member, about);
    }
  }
  template <HasFields T>
  void field(std::string_view key, std::vector<T>& list, const Field& = {}) const {
    list.resize(elements(key, list.size()));
    for (std::size_t i = 0; i < list.size(); ++i) section(key, static_cast<int>(i)).visit_struct(list[i]);
  }
  template <class T>
  void field(std::string_view key, std::map<std::string, T, std::less<>>& by_name, const Field& about = {}) const {
    std::vector<std::string> have;
    for (const auto& [name, one] : by_name) have.push_back(name);
    for (const std::string& name : section(key).names(std::move(have))) section(key).field(name, by_name[name], about);
  }

 private:
  friend class Config;
  friend std::vector<KeyRow> list_keys(const std::string& table, const std::function<void(const Section&)>& fields);
  Section(std::shared_ptr<State> state, std::string path) : state_(std::move(state)), path_(std::move(path)) {}
  template <HasFields T>
  void visit_struct(T& all) const {
    all.fields(*this);
    if constexpr (requires { all.check(*this); })
      if (is_filling()) all.check(*this);
  }
  void visit(const std::function<void(const Section&)>& fields) const;
  bool is_filling() const;
  void value(std::string_view key, Member member, const Field& about) const;
  void check_value(std::string_view key, const Member& member, const Field& about) const;
  void seconds(std::string_view key, std::chrono::microseconds& member, const Field& about) const;
  std::size_t elements(std::string_view key, std::size_t have) const;
  std::vector<std::string> names(std::vector<std::string> have) const;

  std::shared_ptr<State> state_;
  std::string path_;
};

class Config {
 public:
  // From lowest to highest priority: the preset, the included files in order, the file, the overrides. `include =
  // ["common.toml"]` and `preset = "paper"` (presets/paper.toml) are looked up beside the file that holds them.
  // Overrides are "dotted.key=value" with a TOML value, or a bare word taken as text; "shark:dotted.key=value" is one
  // for lab shark only, and refused when the file is another's. Throws ConfigError.
  static Config from_file(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});
  // The same from text; `name` stands for the file in messages.
  static Config from_text(std::string_view text, std::string_view name, const std::vector<std::string>& overrides = {});

  Section root() const { return Section(state_, ""); }
  const std::filesystem::path& file() const;
  // Names of the files that it was read from, seen from the folder of file(): that one, what it includes, its preset.
  std::vector<std::string> files() const;
  // Throws ConfigError when the files hold a key that nobody has read, naming it and the key that was probably meant.
  // With `below` only keys of that table count, for a program that reads one table of a lab's file.
  void refuse_unknown(std::string_view below = {}) const;
  // Every key that was read with its value in force, as TOML that loads again and gives the same run, also when
  // `folder`, where it is to lie, is moved: files of arkmesh itself are written as "arkmesh:...", and others below the
  // current folder relative to `folder`, if that lies there too. What is `kept` in `folder` is named by its place
  // there.
  using Kept = std::map<std::filesystem::path, std::filesystem::path>;
  std::string effective(const std::filesystem::path& folder = {}, const Kept& kept = {}) const;
  // All files and folders that were read as such, in order.
  std::vector<std::filesystem::path> paths() const;
  // The same below a table ("scenario": scenario.dhtf.cells, ...), "" for all; of a path of others its last part.
  std::map<std::string, std::string, std::less<>> in_force_below(std::string_view table) const;

 private:
  Config(const std::filesystem::path& file, const std::string_view* text, const std::vector<std::string>& overrides);
  std::shared_ptr<Section::State> state_;
};

// The keys of structs: `fields` visits them as those of `table`.
std::vector<KeyRow> list_keys(const std::string& table, const std::function<void(const Section&)>& fields);
template <HasFields T>
std::vector<KeyRow> keys_of(const std::string& table) {
  return list_keys(table, [](const Section& s) {
    T defaults;
    defaults.fields(s);
  });
}
// As a table in Markdown, and as a commented file.
std::string print_keys(const std::vector<KeyRow>& rows);
std::string print_sample(std::vector<KeyRow> rows);

// A text or a number as TOML that loads again with the same value.
std::string to_toml(const std::variant<std::string, double>& value);

}  // namespace arkmesh::hal
