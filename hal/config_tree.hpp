// What configuration files say, as one flat tree that files can be laid over each other in: dotted keys to values, each
// with the place it came from. Knows nothing of TOML files, defaults or who reads what.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace arkmesh::hal {

// Where a value was written.
struct ConfigOrigin {
  std::shared_ptr<const std::string> source;  // a file, or "--set key=value"
  unsigned line = 0;                          // 0: the source has no lines
  std::filesystem::path folder;               // what a relative path is relative to

  // "shark.toml:12", or the override
  std::string place() const;
};

// A value without a use here: dates, times, lists with tables in them. Kept as text for messages.
struct ConfigOther {
  std::string toml;
};

struct ConfigValue {
  using List = std::vector<ConfigValue>;
  std::variant<std::string, std::int64_t, double, bool, List, ConfigOther> content;
  ConfigOrigin origin;
};

// As TOML that loads again with the same value and type.
std::string to_toml(std::string_view text);
std::string to_toml(double number);
std::string to_toml(const ConfigValue& value);
// A key as TOML writes it: bare where it can be, else in quotes.
std::string to_toml_key(std::string_view key);

// One step of a dotted key: "peers[0]" is {"peers", 0}. Quoted names keep their quotes.
struct ConfigStep {
  std::string name;
  int index = -1;
};
std::vector<ConfigStep> split_key(std::string_view dotted);
std::string join_key(std::string_view table, std::string_view key);

// Keys are dotted; elements of arrays of tables are "gateway.peers[0]".
struct ConfigTree {
  struct Array {
    std::size_t size = 0;
    ConfigOrigin origin;
  };
  template <class T>
  using Map = std::map<std::string, T, std::less<>>;
  Map<ConfigValue> values;
  Map<ConfigOrigin> tables;
  Map<Array> arrays;  // of tables

  // Each replaces whatever else the key was before; a table keeps the keys that it had.
  void set_value(const std::string& key, ConfigValue value);
  void open_table(const std::string& key, const ConfigOrigin& origin);
  void set_array(const std::string& key, Array array);
  // Lays another tree over this one, table by table; values and arrays of tables are replaced as a whole.
  void lay_over(const ConfigTree& upper);

 private:
  void clear(std::string_view key);
};

}  // namespace arkmesh::hal
