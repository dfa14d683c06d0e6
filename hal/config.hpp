// Strict configuration: every key is read by exactly one place, has a default or is required, and an unknown or
// ill-typed key ends the program with file, line and key named. What was read can be written back as the effective
// configuration.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace arkmesh::hal {

// One sentence: file:line: key: what is wrong and what to do.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Allowed range of a number, bounds included.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

// A table of the file, by dotted path. Cheap to copy; all copies share what the file said and what was read.
// A getter called for a key that the file does not hold returns the default and notes it for the effective
// configuration.
class Section {
 public:
  double number(std::string_view key, double otherwise, Range range = {}) const;
  std::int64_t integer(std::string_view key, std::int64_t otherwise,
                       std::int64_t low = std::numeric_limits<std::int64_t>::min(),
                       std::int64_t high = std::numeric_limits<std::int64_t>::max()) const;
  bool flag(std::string_view key, bool otherwise) const;
  std::string text(std::string_view key, std::string_view otherwise) const;
  // One of `allowed`; the error lists them.
  std::string choice(std::string_view key, std::string_view otherwise, const std::vector<std::string>& allowed) const;
  std::vector<std::string> texts(std::string_view key, const std::vector<std::string>& otherwise) const;
  std::vector<double> numbers(std::string_view key, const std::vector<double>& otherwise, Range range = {}) const;
  // As text, required: no default.
  std::string required_text(std::string_view key) const;
  // A path; relative ones are relative to the file that holds the key. Empty stays empty.
  std::filesystem::path path(std::string_view key, std::string_view otherwise) const;

  // A sub-table (empty when the file has none; its keys then have their defaults).
  Section section(std::string_view key) const;
  // The tables of an array of tables, in file order.
  std::vector<Section> sections(std::string_view key) const;
  // Names of the sub-tables that the file holds below `key`, ascending ([peers.a], [peers.b]).
  std::vector<std::string> names_below(std::string_view key) const;
  bool has(std::string_view key) const;
  // The table `key` belongs to a choice that was not made ([arena.ode] with arena.use = "null"): its keys are neither
  // read nor unknown, and are not part of the effective configuration.
  void leave_alone(std::string_view key) const;

  // Throws a ConfigError about one key of this section: "file:line: section.key = value: <sentence>".
  [[noreturn]] void refuse(std::string_view key, std::string_view sentence) const;

 private:
  friend class Config;
  struct Shared;
  Section(std::shared_ptr<Shared> shared, std::string path) : shared_(std::move(shared)), path_(std::move(path)) {}
  std::shared_ptr<Shared> shared_;
  std::string path_;
};

class Config {
 public:
  // Reads a TOML file. Top-level `include = ["common.toml"]` reads those first (relative to the file); the file
  // overrides them table by table. `overrides` are "dotted.key=value" with a TOML value, or a bare word taken as text;
  // they win. Throws ConfigError.
  static Config from_file(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});
  // The same from text; `name` stands for the file in messages.
  static Config from_text(std::string_view text, std::string_view name, const std::vector<std::string>& overrides = {});

  Section root() const;
  const std::filesystem::path& file() const;
  // Throws ConfigError when the file holds a key that nobody has asked for, naming it and, when one is near, the key
  // that was probably meant. With `below` only keys of that table count, for a program that reads one table of a lab's
  // file.
  void refuse_unknown(std::string_view below = {}) const;
  // Every key that was asked for with its value in force, as TOML that loads again and gives the same run.
  std::string effective() const;
  // Every key in force below `prefix` (dotted; "scenario" gives scenario.use, scenario.dhtf.cells, ...), as TOML
  // values.
  std::map<std::string, std::string> in_force_below(std::string_view prefix) const;

 private:
  std::shared_ptr<Section::Shared> shared_;
};

}  // namespace arkmesh::hal
