#include "view/seats.hpp"

#include <utility>

#include "view/connection.hpp"

namespace arkmesh::view {

Seats::Verdict Seats::for_connection() const {
  if (seats_.size() < viewers_ + beside_) return {};
  const Seat* quietest = nullptr;
  for (const auto& [connection, seat] : seats_)
    if (!connection->may_control && !watching_.contains(connection) && (!quietest || seat.heard < quietest->heard))
      quietest = &seat;
  return {quietest != nullptr, quietest ? quietest->who : nullptr};
}

Seats::Verdict Seats::for_viewer(bool has_token) const {
  if (watching_.size() < viewers_) return {};
  if (!has_token) return {.admitted = false, .leaves = nullptr};
  const Seat* newest = nullptr;
  for (Connection* const viewer : watching_)
    if (const Seat& seat = seats_.at(viewer);
        !viewer->may_control && (!newest || seat.watches_since > newest->watches_since))
      newest = &seat;
  return {newest != nullptr, newest ? newest->who : nullptr};
}

void Seats::add(std::shared_ptr<Connection> connection) {
  Connection* const key = connection.get();
  seats_[key] = {.who = std::move(connection), .heard = ++turn_};
}

void Seats::heard(Connection& connection) {
  if (const auto seat = seats_.find(&connection); seat != seats_.end()) seat->second.heard = ++turn_;
}

void Seats::watch(Connection& connection) {
  seats_.at(&connection).watches_since = ++turn_;
  watching_.insert(&connection);
}

bool Seats::remove(Connection& connection) {
  const bool watched = watching_.erase(&connection) > 0;
  seats_.erase(&connection);
  return watched;
}

std::vector<std::shared_ptr<Connection>> Seats::all() const {
  std::vector<std::shared_ptr<Connection>> out;
  for (const auto& [connection, seat] : seats_) out.push_back(seat.who);
  return out;
}

}  // namespace arkmesh::view
