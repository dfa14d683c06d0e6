#include "recording/export/hdf5.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/files/replace_file.hpp"
#include "recording/export/out_file.hpp"

namespace arkmesh::recording {
namespace {

using namespace hal::layout;

constexpr std::size_t block_bytes = 512 << 10;   // of rows that are written at once, and a chunk of the file
constexpr std::size_t max_text_bytes = 1 << 16;  // an HDF5 member of a compound ends there

std::string key_of(const std::string& group, const std::string& name) {
  return group + "\n" + name;
}

// Why the library's last call failed: in the system's words, if they are among its own.
std::string why() {
  std::string out;
  const auto take = [](unsigned, const H5E_error2_t* error, void* to) -> herr_t {
    std::string& said = *static_cast<std::string*>(to);
    const std::string all = error->desc ? error->desc : "";
    constexpr std::string_view before = "error message = '";
    const std::size_t begin = all.find(before);
    if (begin != std::string::npos)
      said = all.substr(begin + before.size(), all.find('\'', begin + before.size()) - begin - before.size());
    else if (said.empty())
      said = all;
    return begin != std::string::npos ? 1 : 0;  // that is all one wants to know
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take, &out);
  return out;
}

[[noreturn]] void fail(std::string_view what) {
  throw std::runtime_error(
      fmt::format("the HDF5 file cannot be written ({}): {}; choose another place with --out, or --csv", what, why()));
}

// Owns one of HDF5's ids.
class Id {
 public:
  Id(hid_t id, herr_t (*closer)(hid_t), std::string_view what) : id_(id), close_(closer) {
    if (id_ < 0) fail(what);
  }
  ~Id() {
    if (id_ >= 0) close_(id_);
  }
  Id(Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Id(const Id&) = delete;
  operator hid_t() const { return id_; }  // NOLINT: it is used as the library's own type
  bool close() { return close_(std::exchange(id_, -1)) >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

void expect(herr_t status, std::string_view what) {
  if (status < 0) fail(what);
}

Id text_type(std::size_t bytes) {
  Id type(H5Tcopy(H5T_C_S1), H5Tclose, "text type");
  expect(H5Tset_size(type, std::max<std::size_t>(bytes, 1)), "text size");
  expect(H5Tset_strpad(type, H5T_STR_NULLPAD), "text padding");
  expect(H5Tset_cset(type, H5T_CSET_UTF8), "text coding");
  return type;
}

void set_attribute(hid_t object, const char* name, const std::vector<std::string>& texts, bool is_list) {
  std::size_t bytes = 1;
  for (const std::string& text : texts) bytes = std::max(bytes, text.size());
  std::string all;
  for (const std::string& text : texts) all += text + std::string(bytes - text.size(), '\0');
  const Id type = text_type(bytes);
  const hsize_t size = texts.size();
  const Id space(is_list ? H5Screate_simple(1, &size, nullptr) : H5Screate(H5S_SCALAR), H5Sclose,
                 "space of an attribute");
  const Id attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, "attribute");
  expect(H5Awrite(attribute, type, all.data()), "attribute");
}

hid_t number_type(Kind kind) {
  switch (kind) {
    case Kind::int8:  // R has no numbers of one byte
    case Kind::boolean:
    case Kind::byte:
    case Kind::int16:
      return H5T_STD_I16LE;
    case Kind::int32:
      return H5T_STD_I32LE;
    case Kind::int64:
      return H5T_STD_I64LE;
    case Kind::float32:
      return H5T_IEEE_F32LE;
    default:
      return H5T_IEEE_F64LE;
  }
}

// Rows as they lie in the file, so that the library converts nothing.
class Hdf5Table : public RowSink {
 public:
  Hdf5Table(hid_t file, const std::string& path, const std::string& comment, std::span<const Column> columns,
            const std::vector<std::size_t>& text_bytes)
      : type_(make_type(columns, text_bytes)), data_(make_data(file, path)) {
    std::vector<std::string> names, units, comments;
    for (const Column& column : columns) {
      names.push_back(column.name);
      units.push_back(column.unit);
      comments.push_back(column.comment);
    }
    set_attribute(data_, "comment", {comment}, false);
    set_attribute(data_, "columns", names, true);
    set_attribute(data_, "units", units, true);
    set_attribute(data_, "comments", comments, true);
    buffer_.reserve(rows_at_once() * row_bytes_);
  }

  void row(std::span<const Value> values) override {
    const std::size_t begin = buffer_.size();
    buffer_.resize(begin + row_bytes_);
    for (std::size_t i = 0; i < values.size(); ++i)
      put(buffer_.data() + begin + members_[i].offset, members_[i], values[i]);
    if (buffer_.size() >= rows_at_once() * row_bytes_) write_out();
  }

  void write_out() {
    const hsize_t count = buffer_.size() / row_bytes_;
    if (count == 0) return;
    const hsize_t begin = rows, end = rows + count;
    expect(H5Dset_extent(data_, &end), "growing table");
    const Id in_file(H5Dget_space(data_), H5Sclose, "space of a table");
    expect(H5Sselect_hyperslab(in_file, H5S_SELECT_SET, &begin, nullptr, &count, nullptr), "rows");
    const Id in_memory(H5Screate_simple(1, &count, nullptr), H5Sclose, "space of rows");
    expect(H5Dwrite(data_, type_, in_memory, in_file, H5P_DEFAULT, buffer_.data()), "rows");
    rows = end;
    buffer_.clear();
  }

  std::uint64_t rows = 0;

 private:
  struct Member {
    Kind kind;
    std::size_t offset, bytes;
  };

  Id make_type(std::span<const Column> columns, const std::vector<std::size_t>& text_bytes) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const Kind kind = columns[i].kind;
      const std::size_t bytes =
          kind == Kind::text ? std::min(text_bytes[i], max_text_bytes) : H5Tget_size(number_type(kind));
      members_.push_back({kind, row_bytes_, bytes});
      row_bytes_ += bytes;
      has_texts_ = has_texts_ || kind == Kind::text;
    }
    Id type(H5Tcreate(H5T_COMPOUND, row_bytes_), H5Tclose, "type of a table");
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (members_[i].kind == Kind::text)
        expect(H5Tinsert(type, columns[i].name.c_str(), members_[i].offset, text_type(members_[i].bytes)), "column");
      else
        expect(H5Tinsert(type, columns[i].name.c_str(), members_[i].offset, number_type(members_[i].kind)), "column");
    }
    return type;
  }

  Id make_data(hid_t file, const std::string& path) {
    const hsize_t none = 0, any = H5S_UNLIMITED, chunk = rows_at_once();
    const Id space(H5Screate_simple(1, &none, &any), H5Sclose, "space of a table");
    const Id how(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "properties");
    expect(H5Pset_chunk(how, 1, &chunk), "chunks");
    if (has_texts_) expect(H5Pset_deflate(how, 1), "compression");  // texts are padded
    const Id links(H5Pcreate(H5P_LINK_CREATE), H5Pclose, "properties");
    expect(H5Pset_create_intermediate_group(links, 1), "groups");
    return Id(H5Dcreate2(file, path.c_str(), type_, space, links, how, H5P_DEFAULT), H5Dclose,
              fmt::format("table {} with {} columns", path, members_.size()));
  }

  std::size_t rows_at_once() const {
    return std::max<std::size_t>(1, std::min<std::size_t>(8192, block_bytes / row_bytes_));
  }

  static void put(std::byte* to, const Member& member, const Value& value) {
    const auto copy = [&](auto number) { std::memcpy(to, &number, sizeof number); };
    switch (member.kind) {
      case Kind::int8:
      case Kind::boolean:
      case Kind::byte:
      case Kind::int16:
        copy(static_cast<std::int16_t>(value.integer));
        break;
      case Kind::int32:
        copy(static_cast<std::int32_t>(value.integer));
        break;
      case Kind::int64:
        copy(value.integer);
        break;
      case Kind::float32:
        copy(static_cast<float>(value.real));
        break;
      case Kind::float64:
        copy(value.real);
        break;
      default:
        std::memcpy(to, value.text.data(), std::min(member.bytes, value.text.size()));
        break;
    }
  }

  std::vector<Member> members_;
  std::size_t row_bytes_ = 0;
  bool has_texts_ = false;
  Id type_, data_;
  std::vector<std::byte> buffer_;
};

}  // namespace

class TextLengths::Table : public RowSink {
 public:
  explicit Table(std::size_t columns) : longest(columns, 1) {}
  void row(std::span<const Value> values) override {
    for (std::size_t i = 0; i < values.size(); ++i)
      if (values[i].kind == Kind::text) longest[i] = std::max(longest[i], values[i].text.size());
  }
  std::vector<std::size_t> longest;
};

TextLengths::TextLengths() = default;
TextLengths::~TextLengths() = default;

RowSink& TextLengths::table(const std::string& group, const std::string& name, const std::string&,
                            std::span<const Column> columns) {
  auto& table = tables_[key_of(group, name)];
  table = std::make_unique<Table>(columns.size());
  return *table;
}

std::size_t TextLengths::of(const std::string& group, const std::string& name, std::size_t column) const {
  const auto found = tables_.find(key_of(group, name));
  return found == tables_.end() || column >= found->second->longest.size() ? 1 : found->second->longest[column];
}

struct Hdf5Tables::State {
  State(const std::filesystem::path& to, const TextLengths& text_lengths)
      : path(to), part(hal::part_of(to)), lengths(text_lengths), file(create(path, part)) {}

  static Id create(const std::filesystem::path& path, const std::filesystem::path& part) {
    H5dont_atexit();  // where closing a file has failed, on a full disk, the library crashes when it ends
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // what goes wrong is said in our words
    make_folder_of(path);
    return Id(H5Fcreate(part.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose, path.string());
  }

  std::filesystem::path path, part;
  const TextLengths& lengths;
  Id file;
  std::vector<std::unique_ptr<Hdf5Table>> tables;
  std::size_t tables_done = 0;  // once finished
  std::uint64_t rows_done = 0;
  bool is_done = false;
};

Hdf5Tables::Hdf5Tables(const std::filesystem::path& file, const TextLengths& lengths)
    : state_(std::make_unique<State>(file, lengths)) {}

Hdf5Tables::~Hdf5Tables() {
  if (state_->is_done) return;
  const std::filesystem::path part = state_->part;
  state_.reset();
  std::error_code error;
  std::filesystem::remove(part, error);
}

RowSink& Hdf5Tables::table(const std::string& group, const std::string& name, const std::string& comment,
                           std::span<const Column> columns) {
  std::vector<std::size_t> text_bytes;
  for (std::size_t i = 0; i < columns.size(); ++i) text_bytes.push_back(state_->lengths.of(group, name, i));
  state_->tables.push_back(
      std::make_unique<Hdf5Table>(state_->file, "/" + group + "/" + name, comment, columns, text_bytes));
  return *state_->tables.back();
}

void Hdf5Tables::text(const std::string& group, const std::string& name, const std::string& text) {
  const Id type = text_type(text.size());
  const Id space(H5Screate(H5S_SCALAR), H5Sclose, "space of a text");
  const Id links(H5Pcreate(H5P_LINK_CREATE), H5Pclose, "properties");
  expect(H5Pset_create_intermediate_group(links, 1), "groups");
  const Id data(
      H5Dcreate2(state_->file, ("/" + group + "/" + name).c_str(), type, space, links, H5P_DEFAULT, H5P_DEFAULT),
      H5Dclose, "text");
  if (!text.empty()) expect(H5Dwrite(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()), "text");
}

void Hdf5Tables::finish() {
  for (const auto& table : state_->tables) table->write_out();
  state_->tables_done = state_->tables.size();
  for (const auto& table : state_->tables) state_->rows_done += table->rows;
  state_->tables.clear();
  if (!state_->file.close()) expect(-1, "end of the file");
  if (const int error = hal::put_in_place(state_->part, state_->path); error != 0)
    throw std::runtime_error(fmt::format("{} cannot be written: {}", state_->path.string(), std::strerror(error)));
  state_->is_done = true;
}

std::size_t Hdf5Tables::tables() const {
  return state_->tables_done;
}

std::uint64_t Hdf5Tables::rows() const {
  return state_->rows_done;
}

}  // namespace arkmesh::recording
