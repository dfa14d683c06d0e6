#include "recording/export/csv.hpp"

#include <charconv>
#include <set>

namespace arkmesh::recording {
namespace {

using namespace hal::layout;

void append_text(std::string& to, std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    to += text;
    return;
  }
  to += '"';
  for (const char c : text) {
    if (c == '"') to += '"';
    to += c;
  }
  to += '"';
}

void append(std::string& to, const Value& value) {
  char digits[32];
  const auto put = [&](auto number) { to.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr); };
  switch (value.kind) {
    case Kind::text:
      append_text(to, value.text);
      break;
    case Kind::float32:
      put(static_cast<float>(value.real));
      break;
    case Kind::float64:
      put(value.real);
      break;
    default:
      put(value.integer);
      break;
  }
}

}  // namespace

class CsvTables::File : public RowSink {
 public:
  File(const std::filesystem::path& file, std::span<const Column> columns) : folder(file.parent_path()), out_(file) {
    for (const Column& column : columns) {
      if (&column != &columns.front()) out_.buffer() += ',';
      append_text(out_.buffer(), column.name);
    }
    out_.buffer() += '\n';
  }
  void row(std::span<const Value> values) override {
    std::string& to = out_.buffer();
    bool is_first = true;
    for (const Value& value : values) {
      if (!is_first) to += ',';
      is_first = false;
      append(to, value);
    }
    to += '\n';
    out_.room();
    ++rows;
  }
  void flush() { out_.flush(); }
  void finish() { out_.finish(); }

  std::uint64_t rows = 0;
  const std::filesystem::path folder;

 private:
  OutFile out_;
};

CsvTables::CsvTables(std::filesystem::path folder) : folder_(std::move(folder)) {}

CsvTables::~CsvTables() {
  if (is_done_) return;
  std::set<std::filesystem::path> folders = {folder_};
  for (const auto& file : files_)
    for (auto above = file->folder; above != folder_ && above != above.parent_path(); above = above.parent_path())
      folders.insert(above);
  files_.clear();
  std::error_code error;  // of folders that hold something of somebody else
  for (auto folder = folders.rbegin(); folder != folders.rend(); ++folder) std::filesystem::remove(*folder, error);
}

RowSink& CsvTables::table(const std::string& group, const std::string& name, const std::string&,
                          std::span<const Column> columns) {
  files_.push_back(std::make_unique<File>(folder_ / group / (name + ".csv"), columns));
  return *files_.back();
}

void CsvTables::finish() {
  // all are on the disk before the first has its name
  for (const auto& file : files_) file->flush();
  for (const auto& file : files_) file->finish();
  is_done_ = true;
}

std::size_t CsvTables::tables() const {
  return files_.size();
}

std::uint64_t CsvTables::rows() const {
  std::uint64_t out = 0;
  for (const auto& file : files_) out += file->rows;
  return out;
}

}  // namespace arkmesh::recording
