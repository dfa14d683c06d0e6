#include "view/seats.hpp"

#include "view/connection.hpp"

namespace arkmesh::view {

Seats::Verdict Seats::for_connection() const {
  if (seats_.size() < viewers_ + beside_) return {};
  Connection* quietest = nullptr;
  for (const auto& [connection, seat] : seats_)
    if (!connection->may_control && !watching_.contains(connection) &&
        (!quietest || seat.heard < seats_.at(quietest).heard))
      quietest = connection;
  return {quietest != nullptr, quietest};
}

Seats::Verdict Seats::for_viewer(bool has_token) const {
  if (watching_.size() < viewers_) return {};
  if (!has_token) return {.admitted = false};
  Connection* newest = nullptr;
  for (Connection* const viewer : watching_)
    if (!viewer->may_control && (!newest || seats_.at(viewer).watches_since > seats_.at(newest).watches_since))
      newest = viewer;
  return {newest != nullptr, newest};
}

void Seats::add(Connection& connection) {
  seats_[&connection].heard = ++turn_;
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

}  // namespace arkmesh::view
