#include "recording/export/run_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <set>

#include "hal/counted.hpp"
#include "recording/csv_table.hpp"
#include "recording/export/message_tables.hpp"
#include "recording/export/names.hpp"

namespace arkmesh::recording {
namespace {

using namespace hal::layout;

namespace fs = std::filesystem;

// Columns of a table of whoever: each name once, not empty, and of one line.
std::vector<Column> columns_of(const CsvTable& table) {
  std::vector<Column> out;
  std::set<std::string> taken;
  for (const CsvTable::Column& column : table.columns) {
    std::string plain = column.name.empty() ? "column" : column.name;
    for (char& c : plain)
      if (static_cast<unsigned char>(c) < ' ') c = '_';
    std::string name = plain;
    for (int number = 2; !taken.insert(name).second; ++number) name = fmt::format("{}_{}", plain, number);
    const auto kind = column.kind == CsvTable::integer ? Kind::int64
                      : column.kind == CsvTable::real  ? Kind::float64
                                                       : Kind::text;
    out.push_back({name, unit_of(name), "", kind});
  }
  return out;
}

bool has_texts(const Type& type) {
  return std::ranges::any_of(type.fields, [](const Field& field) {
    return field.kind == Kind::text || (field.kind == Kind::byte && !field.sizes.empty()) ||
           (field.type && has_texts(*field.type));
  });
}

void write_messages(const RecordedLab& lab, const std::string& group, TableSink& sink, Names& names, Which which,
                    Watch& watch, Notes& notes) {
  const Log& log = *lab.log;
  // A channel's tables begin with its first message that is ours; messages of another type than that are counted.
  struct Channel {
    std::string name;
    const Type* type = nullptr;
    std::unique_ptr<MessageTables> tables;
    std::map<std::string, std::uint64_t, std::less<>> refused;
  };
  std::vector<Channel> channels(log.channels().size());
  // The lab's own channels first, so that a lab with the name of a channel does not take it. A dot separates a list's
  // name.
  for (const bool is_own : {true, false})
    for (std::size_t i = 0; i < channels.size(); ++i) {
      std::string name = log.channels()[i];
      std::ranges::replace(name, '.', '_');
      if ((name.find('/') == std::string::npos) == is_own) channels[i].name = names.of(name);
    }
  for (const Log::Entry& entry : log.entries()) {
    watch.step();
    Channel& channel = channels[entry.channel];
    if (which == Which::with_texts && channel.type && !has_texts(*channel.type)) continue;
    const auto message = log.read(entry);
    const Type* const type = type_of(message, types());
    if (!channel.type && type) {
      channel.type = type;
      if (which == Which::all || has_texts(*type))
        channel.tables = std::make_unique<MessageTables>(sink, group, channel.name, *type);
    }
    const std::string_view damage = type ? check(*type, message) : std::string_view();
    const std::string why = !type                  ? "of a type unknown to this version"
                            : type != channel.type ? "of another version than the earlier ones"
                            : !damage.empty()      ? fmt::format("damaged ({})", damage)
                                                   : "";
    if (why.empty() && channel.tables)
      channel.tables->add(entry.t_us, message);
    else if (!why.empty())
      ++channel.refused[why];
  }
  // channels of which nothing is known are in the run's own notes
  for (std::size_t i = 0; i < channels.size(); ++i)
    if (channels[i].type)
      for (const auto& [why, count] : channels[i].refused)
        notes.push_back(fmt::format("{}: left out: {} on {}, {}", lab.name, hal::counted(count, "message"),
                                    log.channels()[i], why));
}

// The tables of a folder, but for those of an export.
void write_csv_tables(const fs::path& folder, const std::string& group, TableSink& sink, Names& names, Which which,
                      Notes& notes) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".csv" && entry.is_regular_file(error)) files.push_back(entry.path());
  std::ranges::sort(files);
  for (const fs::path& file : files) {
    const CsvTable table = read_csv_table(file);
    if (table.columns.empty()) continue;
    if (table.dropped > 0)
      notes.push_back(fmt::format("{}: left out: {} cut or not fitting its header", file.string(),
                                  hal::counted(table.dropped, "row")));
    const std::vector<Column> columns = columns_of(table);
    const std::string name = names.of("tables/" + file.stem().string());
    if (which == Which::with_texts && std::ranges::find(columns, Kind::text, &Column::kind) == columns.end()) continue;
    RowSink& rows = sink.table(group, name, "a table that the lab wrote", columns);
    std::vector<Value> row(columns.size());
    for (std::size_t i = 0; i < table.rows; ++i) {
      for (std::size_t c = 0; c < columns.size(); ++c) {
        const std::string& text = table.columns[c].texts[i];
        row[c].kind = columns[c].kind;
        row[c].text = text;
        if (columns[c].kind == Kind::int64) std::from_chars(text.data(), text.data() + text.size(), row[c].integer);
        if (columns[c].kind == Kind::float64) row[c].real = table.number(c, i);
      }
      rows.row(row);
    }
  }
}

}  // namespace

std::vector<std::string> groups_of(const Run& run) {
  Names names;
  std::vector<std::string> out;
  for (const RecordedLab& lab : run.labs()) out.push_back(names.of(safe_name(lab.name)));
  return out;
}

Notes write_tables(const Run& run, TableSink& sink, Watch& watch, Which which) {
  Notes notes;
  const std::vector<std::string> groups = groups_of(run);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const RecordedLab& lab = run.labs()[i];
    const std::string& group = groups[i];
    Names names({"tables"});
    write_messages(lab, group, sink, names, which, watch, notes);
    write_csv_tables(lab.folder, group, sink, names, which, notes);
  }
  return notes;
}

}  // namespace arkmesh::recording
