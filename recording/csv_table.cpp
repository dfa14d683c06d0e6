#include "recording/csv_table.hpp"

#include <charconv>
#include <cstdint>
#include <limits>

#include "hal/files/whole_file.hpp"

namespace arkmesh::recording {
namespace {

constexpr std::uintmax_t max_bytes = 256 << 20;

template <class Number>
bool is_number(const std::string& text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return !text.empty() && error == std::errc() && end == text.data() + text.size();
}

// The values of one row from `at` on, which ends behind its line; false: the row is not whole.
bool read_row(const std::string& all, std::size_t& at, std::vector<std::string>& values) {
  values.assign(1, {});
  bool in_quotes = false;
  for (; at < all.size(); ++at) {
    const char c = all[at];
    if (in_quotes) {
      if (c != '"')
        values.back() += c;
      else if (at + 1 < all.size() && all[at + 1] == '"')
        values.back() += all[++at];
      else
        in_quotes = false;
    } else if (c == '"' && values.back().empty()) {
      in_quotes = true;
    } else if (c == ',') {
      values.emplace_back();
    } else if (c == '\n') {
      ++at;
      return true;
    } else if (c != '\r') {
      values.back() += c;
    }
  }
  return false;
}

}  // namespace

std::optional<std::size_t> CsvTable::find(std::string_view column) const {
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (columns[i].name == column) return i;
  return {};
}

double CsvTable::number(std::size_t column, std::size_t row) const {
  const std::string& value = columns[column].texts[row];
  double out = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), out);
  const bool is_whole = error == std::errc() && !value.empty() && end == value.data() + value.size();
  return is_whole ? out : std::numeric_limits<double>::quiet_NaN();
}

CsvTable read_csv_table(const std::filesystem::path& file) {
  CsvTable out;
  const std::string all = hal::whole_file(file, max_bytes).value_or("");
  std::size_t at = 0;
  std::vector<std::string> values;
  if (!read_row(all, at, values)) return out;
  for (std::string& name : values) out.columns.push_back({std::move(name), {}, CsvTable::integer});
  while (at < all.size()) {
    if (!read_row(all, at, values) || values.size() != out.columns.size()) {
      ++out.dropped;
      continue;
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
      CsvTable::Column& column = out.columns[i];
      if (column.kind == CsvTable::integer && !is_number<std::int64_t>(values[i])) column.kind = CsvTable::real;
      if (column.kind == CsvTable::real && !values[i].empty() && !is_number<double>(values[i]))
        column.kind = CsvTable::text;
      column.texts.push_back(std::move(values[i]));
    }
    ++out.rows;
  }
  return out;
}

}  // namespace arkmesh::recording
