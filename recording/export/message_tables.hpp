// The messages of one channel as tables: one with a row for each message, and one for each list in it, with a row for
// each element. A row of a list repeats the lab time and the number of its message, and of each list around it what its
// elements are known by.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "recording/export/tables.hpp"

namespace arkmesh::recording {

class MessageTables {
 public:
  // `name` of the table of messages; those of lists are name.list, name.list.list, ... `sink` outlives this.
  MessageTables(TableSink& sink, const std::string& group, const std::string& name, const hal::layout::Type& type);
  ~MessageTables();
  // A message that check() has passed.
  void add(std::int64_t t_us, std::span<const std::byte> message);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arkmesh::recording
