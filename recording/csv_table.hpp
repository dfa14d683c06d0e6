// A CSV table that a lab wrote, which may be cut in its last row.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace arkmesh::recording {

struct CsvTable {
  enum ColumnKind { integer, real, text };
  struct Column {
    std::string name;
    std::vector<std::string> texts;  // as in the file, without quotes
    ColumnKind kind = integer;       // what every row is; an empty value makes a column of numbers `real`
  };

  std::vector<Column> columns;  // none: the file is no table
  std::size_t rows = 0;
  std::size_t dropped = 0;  // rows with another number of values than the header

  std::optional<std::size_t> find(std::string_view column) const;
  // NaN where the value is empty or no number.
  double number(std::size_t column, std::size_t row) const;
};

// Files above 256 MB are taken as no table.
CsvTable read_csv_table(const std::filesystem::path& file);

}  // namespace arkmesh::recording
