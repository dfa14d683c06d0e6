// Tables as datasets of an HDF5 file (format of library 1.10): one-dimensional, of a compound type with a member for
// each column, which h5py reads as a structured array, R as a data frame and MATLAB as a struct. Attributes: `comment`,
// and for the columns in their order `columns`, `units` and `comments`. Texts have a fixed length, UTF-8, padded with
// zeros.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>

#include "recording/export/tables.hpp"

namespace arkmesh::recording {

// How long the texts of each column are: a first pass over the tables finds it out, for HDF5 has to know before the
// first row.
class TextLengths : public TableSink {
 public:
  TextLengths();
  ~TextLengths() override;
  RowSink& table(const std::string& group, const std::string& name, const std::string& comment,
                 std::span<const Column> columns) override;
  // In bytes, at least 1.
  std::size_t of(const std::string& group, const std::string& name, std::size_t column) const;

 private:
  class Table;
  std::map<std::string, std::unique_ptr<Table>> tables_;
};

class Hdf5Tables : public TableSink {
 public:
  // Writes FILE.PROCESS.part until finish(). Throws std::runtime_error with one sentence, as all here.
  Hdf5Tables(const std::filesystem::path& file, const TextLengths& lengths);
  ~Hdf5Tables() override;
  RowSink& table(const std::string& group, const std::string& name, const std::string& comment,
                 std::span<const Column> columns) override;
  // A text as a dataset of its own: configuration, results.
  void text(const std::string& group, const std::string& name, const std::string& text);
  void finish();
  // Once finished.
  std::size_t tables() const;
  std::uint64_t rows() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arkmesh::recording
