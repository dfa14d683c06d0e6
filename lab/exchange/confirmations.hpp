// Whether a lab's events have come through: which were told, which were shown to have arrived, which are overdue. Pure:
// counts periods, knows no time.
#pragma once

#include <cstdint>
#include <deque>

namespace arkmesh::lab {

class Confirmations {
 public:
  // `within`: after so many periods an event should have been confirmed.
  explicit Confirmations(std::uint32_t within) : within_(within) {}

  // The own state of boundary `period` was published. `is_event`: with a payload of its own, which is told from now on.
  void published(std::uint32_t period, bool is_event);
  // Events to boundary `period` have arrived, also those that newer ones have replaced.
  void shown(std::int64_t period);

  std::uint64_t told() const { return told_; }
  std::uint64_t confirmed() const { return confirmed_; }
  std::uint64_t unconfirmed() const { return unconfirmed_; }  // that were overdue, confirmed later or not
  std::uint64_t resent() const { return resent_; }            // periods in which an overdue one was told again

 private:
  struct Event {
    std::uint32_t period;
    bool overdue;
  };
  std::uint32_t within_;
  std::deque<Event> waiting_;  // ascending period
  std::uint64_t told_ = 0, confirmed_ = 0, unconfirmed_ = 0, resent_ = 0;
};

}  // namespace arkmesh::lab
