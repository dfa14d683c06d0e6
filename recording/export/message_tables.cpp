// Each place in the type's tree has a node: a record that fills columns of a table, or a list with a table of its own.
// While a message is visited, the path of nodes from its root is on a stack.
#include "recording/export/message_tables.hpp"

#include <algorithm>
#include <cassert>
#include <deque>

namespace arkmesh::recording {
namespace {

using namespace hal::layout;

struct Table {
  RowSink* rows = nullptr;
  std::vector<Column> columns;
  std::vector<Value> row;
  std::size_t keys = 0;  // the first columns: time, message, and what tells the elements of the lists around
};

struct Node {
  Table* table = nullptr;
  const Type* type = nullptr;  // of a record; null: a list of single values
  bool is_row = false;         // a record that ends a row; false: one within another record
  int place_column = -1;       // where the place in the list is written
  int key_column = -1;         // which column lists below repeat; -1: none
  // Of each field of the type: its column, or its node.
  std::vector<int> columns;
  std::vector<std::unique_ptr<Node>> below;
};

// What an element of a list is known by: its first field, if that is a text or a whole number that tells no size.
bool has_key(const Type& type) {
  if (type.fields.empty()) return false;
  const Field& first = type.fields.front();
  return first.sizes.empty() && first.slot < 0 &&
         (first.kind == Kind::text || first.kind == Kind::int32 || first.kind == Kind::int64 ||
          first.kind == Kind::int16);
}

constexpr char digits[] = "0123456789abcdef";

}  // namespace

struct MessageTables::State : Visitor {
  TableSink& sink;
  std::string group;
  std::vector<std::unique_ptr<Table>> tables;
  Node root;
  std::vector<Node*> path;
  std::deque<std::string> hex;  // texts of byte lists in the message at hand
  std::int64_t messages = 0;

  State(TableSink& to, std::string group_name) : sink(to), group(std::move(group_name)) {}

  Table& new_table() { return *tables.emplace_back(std::make_unique<Table>()); }

  static int add_column(Table& table, Column column, const std::string& prefix) {
    const auto is_taken = [&](const std::string& name) {
      return std::ranges::any_of(table.columns, [&](const Column& known) { return known.name == name; });
    };
    while (is_taken(column.name)) column.name = prefix + "_" + column.name;
    table.columns.push_back(std::move(column));
    return static_cast<int>(table.columns.size()) - 1;
  }

  // The columns of a record and the tables of its lists. `dotted`: the fields' names within a record of a record.
  void plan(Node& node, const Type& type, const std::string& table_name, const std::string& dotted) {
    node.type = &type;
    for (const Field& field : type.fields) {
      node.columns.push_back(-1);
      node.below.push_back(nullptr);
      const bool is_bytes = field.kind == Kind::byte && !field.sizes.empty();
      if ((field.sizes.empty() && field.kind != Kind::record) || is_bytes)
        node.columns.back() = add_column(
            *node.table,
            {dotted + field.name, field.unit, is_bytes ? "hexadecimal digits; " + field.comment : field.comment,
             is_bytes ? Kind::text : field.kind},
            "own");
    }
    if (has_key(type) && node.is_row) node.key_column = node.columns.front();
    for (std::size_t i = 0; i < type.fields.size(); ++i) {
      const Field& field = type.fields[i];
      if (node.columns[i] >= 0) continue;
      node.below[i] = std::make_unique<Node>();
      Node& below = *node.below[i];
      if (field.sizes.empty()) {
        below.table = node.table;
        below.key_column = node.key_column;
        below.place_column = node.place_column;
        plan(below, *field.type, table_name, dotted + field.name + ".");
      } else {
        plan_list(node, below, field, table_name + "." + dotted + field.name);
      }
    }
  }

  void plan_list(const Node& around, Node& list, const Field& field, const std::string& table_name) {
    Table& table = new_table();
    list.table = &table;
    list.is_row = true;
    for (std::size_t i = 0; i < around.table->keys; ++i) table.columns.push_back(around.table->columns[i]);
    const int key = around.key_column >= 0 ? around.key_column : around.place_column;
    if (key >= static_cast<int>(around.table->keys))
      add_column(table, around.table->columns[static_cast<std::size_t>(key)], "of");
    table.keys = table.columns.size();
    if (!field.type || !has_key(*field.type))
      list.place_column =
          add_column(table, {field.name + "_place", "", "place in the list, from 0", Kind::int64}, "own");
    if (field.type)
      plan(list, *field.type, table_name, "");
    else
      list.columns = {add_column(table, {field.name, field.unit, field.comment, field.kind}, "own")};
    open(table, table_name, field.comment);
  }

  void open(Table& table, const std::string& name, const std::string& comment) {
    table.row.resize(table.columns.size());
    for (std::size_t i = 0; i < table.columns.size(); ++i) table.row[i].kind = table.columns[i].kind;
    table.rows = &sink.table(group, name, comment, table.columns);
  }

  static std::size_t number_of(const Node& node, const Field& field) {
    return static_cast<std::size_t>(&field - node.type->fields.data());
  }

  void value(const Field& field, const Value& value) override {
    Node& node = *path.back();
    if (node.type) {
      node.table->row[static_cast<std::size_t>(node.columns[number_of(node, field)])] = value;
      return;
    }
    node.table->row[static_cast<std::size_t>(node.columns.front())] = value;
    node.table->rows->row(node.table->row);
    ++node.table->row[static_cast<std::size_t>(node.place_column)].integer;
  }

  void bytes(const Field& field, std::span<const std::byte> bytes) override {
    Node& node = *path.back();
    std::string text;
    text.reserve(2 * bytes.size());
    for (const std::byte b : bytes) {
      text += digits[std::to_integer<unsigned>(b) >> 4];
      text += digits[std::to_integer<unsigned>(b) & 15];
    }
    hex.push_back(std::move(text));
    node.table->row[static_cast<std::size_t>(node.columns[number_of(node, field)])].text = hex.back();
  }

  void begin_list(const Field& field, std::size_t) override {
    Node& around = *path.back();
    Node& list = *around.below[number_of(around, field)];
    path.push_back(&list);
    // the keys of this list's rows: those of the record around it, and what that one is known by
    const Table& outer = *around.table;
    std::copy_n(outer.row.begin(), outer.keys, list.table->row.begin());
    if (list.table->keys > outer.keys) {
      const int key = around.key_column >= 0 ? around.key_column : around.place_column;
      list.table->row[outer.keys] = outer.row[static_cast<std::size_t>(key)];
    }
    if (list.place_column >= 0) list.table->row[static_cast<std::size_t>(list.place_column)].integer = 0;
  }
  void end_list(const Field&) override { path.pop_back(); }

  void begin_record(const Field& field, std::size_t place) override {
    Node& node = *path.back();
    if (node.is_row && node.type == field.type && !field.sizes.empty()) {
      if (node.place_column >= 0)
        node.table->row[static_cast<std::size_t>(node.place_column)].integer = static_cast<std::int64_t>(place);
      path.push_back(&node);
    } else {
      path.push_back(node.below[number_of(node, field)].get());
    }
  }
  void end_record(const Field&) override {
    Node& node = *path.back();
    path.pop_back();
    if (node.is_row) node.table->rows->row(node.table->row);
  }
};

MessageTables::MessageTables(TableSink& sink, const std::string& group, const std::string& name, const Type& type)
    : state_(std::make_unique<State>(sink, group)) {
  State& s = *state_;
  Table& table = s.new_table();
  table.columns = {{"time_s", "s", "lab time", Kind::float64},
                   {"message", "", "number of the message on its channel, from 0", Kind::int64}};
  table.keys = 2;
  s.root.table = &table;
  s.plan(s.root, type, name, "");
  s.open(table, name, type.comment);
}

MessageTables::~MessageTables() = default;

void MessageTables::add(std::int64_t t_us, std::span<const std::byte> message) {
  State& s = *state_;
  std::vector<Value>& row = s.root.table->row;
  row[0].real = static_cast<double>(t_us) / 1e6;
  row[1].integer = s.messages++;
  s.hex.clear();
  s.path.assign(1, &s.root);
  visit(*s.root.type, message, s);
  assert(s.path.size() == 1 && "every list and record ends");
  s.root.table->rows->row(row);
}

}  // namespace arkmesh::recording
