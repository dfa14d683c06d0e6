// Tables as exports write them: named, with typed columns, filled row by row.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/layout/message.hpp"

namespace arkmesh::recording {

struct Column {
  std::string name;     // ends in its unit, if it has one: "x_m"
  std::string unit;     // "m"; empty: none
  std::string comment;  // as in the .lcm file
  hal::layout::Kind kind = hal::layout::Kind::int32;
};

class RowSink {
 public:
  virtual ~RowSink() = default;
  // One value for each column, of its kind.
  virtual void row(std::span<const hal::layout::Value> values) = 0;
};

class TableSink {
 public:
  virtual ~TableSink() = default;
  // Called once for each table, in any order; rows of several tables come in turn. `group` is a lab's name, `name` may
  // have parts that are joined by '/' (channels of other labs); both are safe (names.hpp). The sink keeps what it
  // returns.
  virtual RowSink& table(const std::string& group, const std::string& name, const std::string& comment,
                         std::span<const Column> columns) = 0;
};

}  // namespace arkmesh::recording
