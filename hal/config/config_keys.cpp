// The keys of structs for readers: a table, and a sample that loads as it is.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <utility>

#include "hal/config/config.hpp"

namespace arkmesh::hal {

namespace {

std::string range_of(const Field& about) {
  const auto [low, high] = about.range;
  if (!about.one_of.empty()) return fmt::format("\"{}\"", fmt::join(about.one_of, "\", \""));
  if (std::isinf(low) && std::isinf(high)) return "";
  if (std::isinf(high)) return fmt::format("at least {}", low);
  return std::isinf(low) ? fmt::format("at most {}", high) : fmt::format("{} to {}", low, high);
}

}  // namespace

std::string print_keys(const std::vector<KeyRow>& rows) {
  std::string out = "| key | type | unit | default | range | meaning |\n|---|---|---|---|---|---|\n";
  for (const auto& [table, key, type, value, about, in_use] : rows)
    out += fmt::format("| `{}.{}` | {} | {} | {} | {} | {} |\n", table, key, type, about.unit,
                       about.required             ? "required"
                       : about.default_is.empty() ? fmt::format("`{}`", value)
                                                  : about.default_is,
                       range_of(about), about.help);
  return out;
}

std::string print_sample(std::vector<KeyRow> rows) {
  // a table may have its header once
  std::ranges::stable_sort(rows, {}, &KeyRow::table);
  std::string out, table;
  for (KeyRow& row : rows) {
    // names of the user's are those of a lab called so
    for (std::string* name : {&row.table, &row.key})
      if (const std::size_t at = name->find("<lab>"); at != std::string::npos) name->replace(at, 5, "lab");
    const bool is_list = row.table.ends_with("[0]");
    const std::string name = is_list ? fmt::format("[{}]", row.table.substr(0, row.table.size() - 3)) : row.table;
    const char* const off = row.in_use && !is_list ? "" : "# ";
    if (name != std::exchange(table, name)) out += fmt::format("\n{}[{}]\n", off, name);
    const std::string range = range_of(row.about);
    out += fmt::format("# {}{}{}\n", row.about.help, row.about.unit.empty() ? "" : fmt::format(" [{}]", row.about.unit),
                       range.empty() ? "" : fmt::format("; {}", range));
    const std::string& value = row.about.sample.empty() ? row.default_value : row.about.sample;
    out += fmt::format("{}{} = {}\n", row.about.default_is.empty() ? off : "# ", row.key, value);
  }
  return out;
}

}  // namespace arkmesh::hal
