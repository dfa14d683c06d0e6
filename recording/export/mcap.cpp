// The names of records and their fields are those of the specification at mcap.dev/spec. All numbers are little-endian.
#include "recording/export/mcap.hpp"

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <stdexcept>

namespace arkmesh::recording {
namespace {

constexpr std::string_view magic("\x89MCAP0\r\n", 8);
constexpr std::size_t chunk_bytes = 4 << 20;
constexpr std::string_view compression = "zstd";

enum Opcode : std::uint8_t {
  header = 1,
  footer = 2,
  schema = 3,
  channel = 4,
  message = 5,
  chunk = 6,
  message_index = 7,
  chunk_index = 8,
  statistics = 0x0b,
  summary_offset = 0x0e,
  data_end = 0x0f
};

void put_number(std::string& to, std::uint64_t value, int bytes) {
  for (; bytes > 0; --bytes, value >>= 8) to += static_cast<char>(value);
}

void put_text(std::string& to, std::string_view text) {
  put_number(to, text.size(), 4);
  to += text;
}

std::string record(Opcode opcode, std::string_view content) {
  std::string out;
  out.reserve(9 + content.size());
  put_number(out, opcode, 1);
  put_number(out, content.size(), 8);
  out += content;
  return out;
}

std::uint32_t crc(std::uint32_t before, std::string_view bytes) {
  return static_cast<std::uint32_t>(crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::string compressed(std::string_view bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), ZSTD_CLEVEL_DEFAULT);
  if (ZSTD_isError(size)) throw std::runtime_error(fmt::format("zstd cannot compress: {}", ZSTD_getErrorName(size)));
  out.resize(size);
  return out;
}

}  // namespace

McapFile::McapFile(const std::filesystem::path& file) : out_(file) {
  put(magic);
  std::string content;
  put_text(content, "");
  put_text(content, "arkmesh " ARKMESH_VERSION);
  put(record(header, content));
}

void McapFile::put(std::string_view bytes) {
  data_crc_ = crc(data_crc_, bytes);
  out_.write(bytes);
}

std::uint16_t McapFile::add_schema(std::string_view name, std::string_view file_descriptors) {
  std::string content;
  const auto id = static_cast<std::uint16_t>(schemas_.size() + 1);  // 0 means none
  put_number(content, id, 2);
  put_text(content, name);
  put_text(content, "protobuf");
  put_text(content, file_descriptors);
  schemas_.push_back(record(schema, content));
  return id;
}

std::uint16_t McapFile::add_channel(std::uint16_t schema_id, std::string_view topic) {
  std::string content;
  const auto id = static_cast<std::uint16_t>(channels_.size());
  put_number(content, id, 2);
  put_number(content, schema_id, 2);
  put_text(content, topic);
  put_text(content, "protobuf");
  put_number(content, 0, 4);  // metadata
  channels_.push_back(record(channel, content));
  return id;
}

void McapFile::add_message(std::uint16_t channel_id, std::uint32_t number, std::uint64_t time_ns,
                           std::string_view bytes) {
  // schemas and channels stand before what uses them
  for (; schemas_in_file_ < schemas_.size(); ++schemas_in_file_) chunk_ += schemas_[schemas_in_file_];
  for (; channels_in_file_ < channels_.size(); ++channels_in_file_) chunk_ += channels_[channels_in_file_];
  const bool is_first = chunk_index_.empty();
  chunk_begin_ns_ = is_first ? time_ns : std::min(chunk_begin_ns_, time_ns);
  chunk_end_ns_ = is_first ? time_ns : std::max(chunk_end_ns_, time_ns);
  begin_ns_ = messages_ == 0 ? time_ns : std::min(begin_ns_, time_ns);
  end_ns_ = messages_ == 0 ? time_ns : std::max(end_ns_, time_ns);
  ++messages_;
  ++counts_[channel_id];
  chunk_index_[channel_id].push_back({time_ns, chunk_.size()});
  put_number(chunk_, message, 1);
  put_number(chunk_, 2 + 4 + 8 + 8 + bytes.size(), 8);
  put_number(chunk_, channel_id, 2);
  put_number(chunk_, number, 4);
  put_number(chunk_, time_ns, 8);
  put_number(chunk_, time_ns, 8);
  chunk_ += bytes;
  if (chunk_.size() >= chunk_bytes) end_chunk();
}

void McapFile::end_chunk() {
  if (chunk_index_.empty()) return;
  const std::uint64_t chunk_start = out_.size();
  std::string content;
  put_number(content, chunk_begin_ns_, 8);
  put_number(content, chunk_end_ns_, 8);
  put_number(content, chunk_.size(), 8);
  put_number(content, crc(0, chunk_), 4);
  put_text(content, compression);
  const std::string packed = compressed(chunk_);
  put_number(content, packed.size(), 8);
  content += packed;
  put(record(chunk, content));
  const std::uint64_t index_start = out_.size();
  std::string offsets;
  for (const auto& [channel_id, entries] : chunk_index_) {
    put_number(offsets, channel_id, 2);
    put_number(offsets, out_.size(), 8);
    std::string index;
    put_number(index, channel_id, 2);
    put_number(index, entries.size() * 16, 4);
    for (const IndexEntry& entry : entries) {
      put_number(index, entry.time_ns, 8);
      put_number(index, entry.offset, 8);
    }
    put(record(message_index, index));
  }
  std::string about;
  put_number(about, chunk_begin_ns_, 8);
  put_number(about, chunk_end_ns_, 8);
  put_number(about, chunk_start, 8);
  put_number(about, index_start - chunk_start, 8);
  put_text(about, offsets);
  put_number(about, out_.size() - index_start, 8);
  put_text(about, compression);
  put_number(about, packed.size(), 8);
  put_number(about, chunk_.size(), 8);
  chunks_.push_back(record(chunk_index, about));
  chunk_.clear();
  chunk_index_.clear();
}

void McapFile::finish() {
  end_chunk();
  std::string content;
  put_number(content, data_crc_, 4);
  out_.write(record(data_end, content));

  // the summary: schemas, channels, statistics, chunks, and where each group of them lies
  const std::uint64_t summary_start = out_.size();
  std::string summary, offsets;
  const auto add_group = [&](Opcode opcode, const std::vector<std::string>& records) {
    if (records.empty()) return;
    const std::size_t begin = summary.size();
    for (const std::string& each : records) summary += each;
    std::string place;
    put_number(place, opcode, 1);
    put_number(place, summary_start + begin, 8);
    put_number(place, summary.size() - begin, 8);
    offsets += record(summary_offset, place);
  };
  std::string numbers, per_channel;
  for (const auto& [channel_id, count] : counts_) {
    put_number(per_channel, channel_id, 2);
    put_number(per_channel, count, 8);
  }
  put_number(numbers, messages_, 8);
  put_number(numbers, schemas_.size(), 2);
  put_number(numbers, channels_.size(), 4);
  put_number(numbers, 0, 4);  // attachments
  put_number(numbers, 0, 4);  // metadata
  put_number(numbers, chunks_.size(), 4);
  put_number(numbers, begin_ns_, 8);
  put_number(numbers, end_ns_, 8);
  put_text(numbers, per_channel);
  add_group(schema, schemas_);
  add_group(channel, channels_);
  add_group(statistics, {record(statistics, numbers)});
  add_group(chunk_index, chunks_);
  const std::uint64_t offsets_start = summary_start + summary.size();
  summary += offsets;
  // the CRC covers the footer up to itself
  put_number(summary, footer, 1);
  put_number(summary, 8 + 8 + 4, 8);
  put_number(summary, summary_start, 8);
  put_number(summary, offsets_start, 8);
  put_number(summary, crc(0, summary), 4);
  out_.write(summary);
  out_.write(magic);
  out_.finish();
}

}  // namespace arkmesh::recording
