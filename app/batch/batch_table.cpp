#include "app/batch/batch_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "app/batch/plain_json.hpp"
#include "hal/record/result_file.hpp"

namespace arkmesh::app {
namespace {

namespace fs = std::filesystem;

std::string written(const nlohmann::json& number) {
  return number.dump();
}

void take_numbers(const nlohmann::json& from, const std::string& prefix, std::map<std::string, std::string>& to) {
  if (!from.is_object()) return;
  for (const auto& [name, value] : from.items())
    if (value.is_number()) to[prefix + name] = written(value);
}

// What each lab counted, but nothing that depends on how long the run took.
void take_lab(const std::string& lab, const nlohmann::json& said, std::map<std::string, std::string>& to) {
  take_numbers(object_in(said, "counters"), lab + ".", to);
  for (const auto& [peer, traffic] : object_in(said, "between_labs").items())
    take_numbers(traffic, fmt::format("{}.between.{}.", lab, peer), to);
}

}  // namespace

bool is_measured(std::string_view column) {
  constexpr std::string_view units[] = {"s", "ms", "us", "m", "mm", "ppm", "rad", "deg"};
  column = column.substr(0, column.find('@'));
  const std::size_t end = column.find_last_of("._");
  return end != column.npos && std::ranges::find(units, column.substr(end + 1)) != std::end(units);
}

bool read_row(const fs::path& directory, BatchRow& row) {
  const hal::ResultFile file(directory);
  if (!file.exists() || file.outcome() == hal::Outcome::running) return false;
  const nlohmann::json& result = file.content();
  row.state = state_of_run(directory);
  row.why = file.ended();
  row.final_hash = file.text("final_hash");
  take_numbers(object_in(result, "counts"), "", row.counts);
  for (const char* key : {"periods", "duration_s"})
    if (result.contains(key) && result.at(key).is_number()) row.numbers[key] = written(result.at(key));
  for (const auto& [lab, said] : object_in(result, "by_lab").items()) take_lab(lab, said, row.numbers);
  return true;
}

std::vector<std::string> columns_of(const std::vector<BatchRow>& rows, bool counts_only) {
  std::set<std::string> counts, numbers;
  for (const BatchRow& row : rows) {
    for (const auto& [name, value] : row.counts) counts.insert(name);
    for (const auto& [name, value] : row.numbers) numbers.insert(name);
  }
  std::vector<std::string> out(counts.begin(), counts.end());
  if (!counts_only)
    std::ranges::copy_if(numbers, std::back_inserter(out),
                         [&](const std::string& name) { return !counts.contains(name); });
  return out;
}

std::string cell(const BatchRow& row, const std::string& column) {
  if (const auto count = row.counts.find(column); count != row.counts.end()) return count->second;
  if (const auto number = row.numbers.find(column); number != row.numbers.end()) return number->second;
  return (row.numbers.empty() && row.counts.empty()) || is_measured(column) ? "" : "0";
}

std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

}  // namespace arkmesh::app
