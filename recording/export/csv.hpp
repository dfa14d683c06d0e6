// Tables as CSV files (RFC 4180): a header row, then a row for each. Numbers are written with as many digits as it
// takes to read the very same number again.
#pragma once

#include <filesystem>
#include <map>
#include <memory>

#include "recording/export/out_file.hpp"
#include "recording/export/tables.hpp"

namespace arkmesh::recording {

class CsvTables : public TableSink {
 public:
  // Writes `folder`/GROUP/NAME.csv.
  explicit CsvTables(std::filesystem::path folder);
  ~CsvTables() override;  // without finish(), takes away what was begun
  RowSink& table(const std::string& group, const std::string& name, const std::string& comment,
                 std::span<const Column> columns) override;
  // Gives the files their names.
  void finish();
  std::size_t tables() const;
  std::uint64_t rows() const;

 private:
  class File;
  std::filesystem::path folder_;
  bool is_done_ = false;
  std::vector<std::unique_ptr<File>> files_;
};

}  // namespace arkmesh::recording
