#include "recording/export/exports.hpp"

#include <fmt/format.h>

#include <map>
#include <optional>
#include <utility>

#include "hal/counted.hpp"
#include "hal/files/whole_file.hpp"
#include "recording/export/csv.hpp"
#include "recording/export/hdf5.hpp"
#include "recording/export/mcap.hpp"
#include "recording/export/names.hpp"
#include "recording/export/proto.hpp"
#include "recording/export/run_tables.hpp"
#include "recording/export/scene.hpp"

namespace arkmesh::recording {
namespace {

using namespace hal::layout;

std::string rows_and_tables(std::size_t tables, std::uint64_t rows) {
  return fmt::format("{} with {}", hal::counted(tables, "table"), hal::counted(rows, "row"));
}

constexpr std::uintmax_t max_file_bytes = 16 << 20;  // of a configuration, of results

std::uint64_t messages_of(const Run& run) {
  std::uint64_t out = 0;
  for (const RecordedLab& lab : run.labs()) out += lab.log->entries().size();
  return out;
}

void append(std::vector<std::string>& to, const std::vector<std::string>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

// The messages of one lab, in the order of their times.
struct Stream {
  struct Channel {
    const Type* type = nullptr;
    std::uint16_t id = 0;
    std::uint32_t messages = 0;
    std::uint64_t refused = 0;
  };
  const RecordedLab* lab = nullptr;
  std::size_t next = 0;
  std::vector<Channel> channels;
  std::string group;
  Names topics;
  std::optional<Scene> scene;
  std::map<std::string_view, Channel> shown;  // by topic

  bool is_at_end() const { return next == lab->log->entries().size(); }
  std::int64_t t_us() const { return lab->log->entries()[next].t_us; }
};

}  // namespace

Exported export_csv(const Run& run, const std::filesystem::path& folder, Watch& watch) {
  watch.expect(messages_of(run));
  CsvTables tables(folder);
  Exported out{{}, run.notes()};
  append(out.notes, write_tables(run, tables, watch));
  tables.finish();
  out.summary = rows_and_tables(tables.tables(), tables.rows());
  return out;
}

Exported export_hdf5(const Run& run, const std::filesystem::path& file, Watch& watch) {
  watch.expect(2 * messages_of(run));
  TextLengths lengths;
  write_tables(run, lengths, watch, Which::with_texts);
  Hdf5Tables tables(file, lengths);
  Exported out{{}, run.notes()};
  append(out.notes, write_tables(run, tables, watch));
  const std::vector<std::string> groups = groups_of(run);
  for (std::size_t i = 0; i < groups.size(); ++i)
    for (const char* name : {"config.toml", "result.json"})
      if (const auto text = hal::whole_file(run.labs()[i].folder / name, max_file_bytes))
        tables.text(groups[i], name, *text);
  tables.finish();
  out.summary = rows_and_tables(tables.tables(), tables.rows());
  return out;
}

Exported export_mcap(const Run& run, const std::filesystem::path& file, Watch& watch) {
  watch.expect(messages_of(run));
  McapFile mcap(file);
  Exported out{{}, run.notes()};
  ProtoTypes protos;
  std::map<std::string, std::uint16_t> schemas;
  const auto schema_of = [&](const google::protobuf::Descriptor& type) {
    auto schema = schemas.find(type.full_name());
    if (schema == schemas.end())
      schema = schemas.emplace(type.full_name(), mcap.add_schema(type.full_name(), proto_schema(type))).first;
    return schema->second;
  };
  double next_x_m = 0;
  std::vector<Stream> streams;
  const std::vector<std::string> groups = groups_of(run);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const RecordedLab& lab = run.labs()[i];
    Stream stream;
    stream.lab = &lab;
    stream.channels.resize(lab.log->channels().size());
    stream.group = groups[i];
    for (const char* topic : {"scene", "robots", "others", "headings", "frames"}) stream.topics.of(topic);
    stream.scene.emplace(lab.name, next_x_m);
    streams.push_back(std::move(stream));
  }
  // labs share lab time, so that they stand side by side
  const std::int64_t start_us = run.labs().front().log->start_utime();
  std::string bytes;
  while (true) {
    Stream* stream = nullptr;
    for (Stream& each : streams)
      if (!each.is_at_end() && (!stream || each.t_us() < stream->t_us())) stream = &each;
    if (!stream) break;
    watch.step();
    const Log& log = *stream->lab->log;
    const Log::Entry& entry = log.entries()[stream->next++];
    Stream::Channel& channel = stream->channels[entry.channel];
    const auto message = log.read(entry);
    const Type* const type = type_of(message, types());
    if (!type || (channel.type && type != channel.type) || !check(*type, message).empty()) {
      ++channel.refused;
      continue;
    }
    const auto time_ns = static_cast<std::uint64_t>(std::max<std::int64_t>(0, start_us + entry.t_us)) * 1000;
    const std::string& name = log.channels()[entry.channel];
    const bool is_new = std::exchange(channel.type, type) == nullptr;
    if (name != "poses") {  // these are shown, and CSV and HDF5 have them as they were
      if (is_new)
        channel.id = mcap.add_channel(schema_of(protos.of(*type)),
                                      fmt::format("/{}/{}", stream->group, stream->topics.of(name)));
      protos.encode(bytes, *type, message);
      mcap.add_message(channel.id, channel.messages++, time_ns, bytes);
    }
    for (const auto& [topic, shown] : stream->scene->update(name, entry.t_us, time_ns, *type, message)) {
      const auto [at, is_first] = stream->shown.try_emplace(topic);
      Stream::Channel& to = at->second;
      if (is_first)
        to.id = mcap.add_channel(schema_of(*shown->GetDescriptor()), fmt::format("/{}/{}", stream->group, topic));
      shown->SerializeToString(&bytes);
      mcap.add_message(to.id, to.messages++, time_ns, bytes);
    }
  }
  mcap.finish();
  for (const Stream& stream : streams)
    for (std::size_t i = 0; i < stream.channels.size(); ++i)
      if (stream.channels[i].type && stream.channels[i].refused > 0)  // else it is in the run's own notes
        out.notes.push_back(fmt::format(
            "{}: left out: {} on {}, damaged, of a type unknown to this version or of another version than the earlier "
            "ones",
            stream.lab->name, hal::counted(stream.channels[i].refused, "message"), stream.lab->log->channels()[i]));
  out.summary =
      fmt::format("{} with {}", hal::counted(mcap.channels(), "channel"), hal::counted(mcap.messages(), "message"));
  return out;
}

}  // namespace arkmesh::recording
