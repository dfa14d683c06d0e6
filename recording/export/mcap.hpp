// An MCAP file (version 0, mcap.dev): messages in chunks compressed by zstd, with CRCs, and at its end an index of
// chunks, channels and schemas, so that readers find what they need without reading the whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "recording/export/out_file.hpp"

namespace arkmesh::recording {

class McapFile {
 public:
  // Throws std::runtime_error with one sentence, as all here, when the disk refuses.
  explicit McapFile(const std::filesystem::path& file);

  // Messages are protocol buffers, the schema is a FileDescriptorSet. Returns its number.
  std::uint16_t add_schema(std::string_view name, std::string_view file_descriptors);
  std::uint16_t add_channel(std::uint16_t schema, std::string_view topic);
  // `time_ns` since 1970. Readers are quick when times do not decrease.
  void add_message(std::uint16_t channel, std::uint32_t number, std::uint64_t time_ns, std::string_view bytes);
  // Writes the index and gives the file its name.
  void finish();
  std::uint64_t messages() const { return messages_; }
  std::size_t channels() const { return channels_.size(); }

 private:
  struct IndexEntry {
    std::uint64_t time_ns, offset;  // offset within the chunk
  };
  void put(std::string_view bytes);
  void end_chunk();

  OutFile out_;
  std::uint32_t data_crc_ = 0;
  std::vector<std::string> schemas_, channels_;  // whole records
  std::size_t schemas_in_file_ = 0, channels_in_file_ = 0;
  std::string chunk_;
  std::uint64_t chunk_begin_ns_ = 0, chunk_end_ns_ = 0;
  std::map<std::uint16_t, std::vector<IndexEntry>> chunk_index_;
  std::vector<std::string> chunks_;  // whole chunk index records
  std::map<std::uint16_t, std::uint64_t> counts_;
  std::uint64_t messages_ = 0, begin_ns_ = 0, end_ns_ = 0;
};

}  // namespace arkmesh::recording
