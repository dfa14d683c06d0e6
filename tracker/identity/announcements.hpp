// Broadcasts that are said one after the other, each for a while: until robots that miss some copies have heard one.
#pragma once

#include <deque>
#include <optional>

#include "hal/types.hpp"
#include "tracker/identity/question.hpp"

namespace arkmesh::tracker {

class Announcements {
 public:
  void add(const Question& message, hal::LabTime lasts) { waiting_.push_back({message, lasts}); }
  // `now` never decreases. True while there is something to say.
  bool say(hal::LabTime now) {
    while (!waiting_.empty()) {
      if (!since_) since_ = now;
      if (now - *since_ < waiting_.front().lasts) return true;
      waiting_.pop_front();
      since_.reset();
    }
    return false;
  }
  std::optional<Question> message() const {
    if (waiting_.empty()) return std::nullopt;
    return waiting_.front().message;
  }
  std::size_t waiting() const { return waiting_.size(); }

 private:
  struct Announcement {
    Question message;
    hal::LabTime lasts;
  };
  std::deque<Announcement> waiting_;
  std::optional<hal::LabTime> since_;  // of the front
};

}  // namespace arkmesh::tracker
