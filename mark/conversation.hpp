// What the original's messages mean, and what it is told next: one class for each experiment and role. Pure: no
// connection, no time.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "mark/vocabulary.hpp"

namespace arkmesh::mark {

class Conversation {
 public:
  virtual ~Conversation() = default;
  // The original is there, anew, or may have begun anew: it may know nothing.
  virtual void came() = 0;
  // It is gone, or labs stand still while it goes on: nobody is ready for the other until news comes of him.
  virtual void gone() = 0;
  virtual void hear(const Message& message) = 0;
  // What it is to be told now, without delimiter; none: nothing. Asked each time that something can be sent.
  virtual std::optional<std::string> say() const = 0;
  // It was sent what say() answered last.
  virtual void said() = 0;
  // The lab's state 0 can be made. Before, `awaited` says what of the original is missing.
  virtual bool may_begin() const = 0;
  virtual std::string awaited() const = 0;
  // The lab has ended: nobody is ready for the original any more, and nothing of its world changes.
  virtual void end() = 0;

  // Why this lab and the original cannot share a world, with both values; empty when they can.
  const std::string& conflict() const { return conflict_; }
  void conflict(std::string sentence) {
    if (conflict_.empty()) conflict_ = std::move(sentence);
  }

 private:
  std::string conflict_;
};

}  // namespace arkmesh::mark
