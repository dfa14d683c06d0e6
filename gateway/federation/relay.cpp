#include "gateway/federation/relay.hpp"

#include <algorithm>
#include <utility>

namespace arkmesh::gateway {

bool Relay::hear(const Greeting& greeting, PacketOrder at) {
  // Who does not know our end may be repeated from long ago: it is told of it, and believed once it names it.
  if (greeting.yours != mine_) {
    if (!met_) yours_ = greeting.mine;
    return true;
  }
  if (is_of_the_past(greeting.mine, at)) return false;
  if (met_ && yours_ != greeting.mine && has_exchanged()) {
    ended_ = true;
    return false;
  }
  meet(greeting.mine, at);
  return greeting.asks;
}

// What earlier ends of the peer have said may still come, or once more; the later packet is right.
void Relay::meet(StreamId theirs, PacketOrder at) {
  const bool is_another = std::exchange(yours_, theirs) != theirs;
  if (is_another || !met_) met_at_ = at;
  if (is_another) send_all_again();
  met_ = true;
}

bool Relay::take(const Piece& piece, const PacketBody& body, PacketOrder at, Time now) {
  if (ended_ || is_of_the_past(piece.mine, at)) return true;
  if (piece.mine != yours_ && has_exchanged()) {
    ended_ = true;
    return true;
  }
  meet(piece.mine, at);
  if (!acknowledged(piece.acknowledged, now)) return false;
  if (piece.asks_again && acknowledged_ < highest_sent_ && now - rewound_ > path_.value_or(least_patience)) rewind(now);
  std::uint64_t next = piece.offset;
  for (const std::uint16_t number : piece.chunks) {
    const auto bytes = body.chunks[number];
    if (next == came_) {
      if (unread_.size() + bytes.size() > max_unread_bytes) {
        counters_.add("pieces.full");
        return true;
      }
      unread_.insert(unread_.end(), bytes.begin(), bytes.end());
      came_ += bytes.size();
    } else if (next < came_) {
      counters_.add("pieces.repeated");
    } else {
      counters_.add("pieces.missing");
      asks_again_ = true;
      return true;
    }
    next += bytes.size();
    if (piece.is_urgent && !owes_since_) owes_since_ = now;
  }
  return true;
}

bool Relay::acknowledged(std::uint64_t total, Time now) {
  if (total > highest_sent_) {
    ended_ = true;
    return false;
  }
  if (total <= acknowledged_) return true;
  acknowledged_ = total;
  while (!chunks_.empty() && chunks_.front().end <= total) {
    chunks_.pop_front();
    next_ -= std::min<std::size_t>(next_, 1);
    once_sent_ -= std::min<std::size_t>(once_sent_, 1);
  }
  progress_ = now;
  if (sample_ && total >= sample_->end) {
    const std::chrono::duration<double> took = now - sample_->sent;
    path_ = path_ ? *path_ * 0.875 + took * 0.125 : took;
    sample_.reset();
  }
  const auto wanted = path_ ? std::chrono::duration_cast<Duration>(*path_ * 2) + 2 * ack_time_ : first_patience;
  patience_ = std::clamp(wanted, least_patience, longest_patience);
  return true;
}

void Relay::put(ChunkPointer chunk) {
  put_ += chunk->bytes.size();
  const bool is_urgent = chunk->is_message || acknowledged_ == 0;
  chunks_.push_back({std::move(chunk), put_, is_urgent});
}

bool Relay::has_fresh_message() const {
  for (std::size_t i = std::max(next_, once_sent_); i < chunks_.size(); ++i)
    if (chunks_[i].chunk->is_message) return true;
  return false;
}

Piece Relay::piece() {
  owes_since_.reset();
  Piece piece{.yours = yours_, .mine = mine_, .acknowledged = came_, .asks_again = std::exchange(asks_again_, false)};
  piece.offset = next_ == 0 ? acknowledged_ : chunks_[next_ - 1].end;
  return piece;
}

bool Relay::sent(Time now) {
  const Entry& entry = chunks_[next_++];
  if (next_ == 1) progress_ = now;
  if (next_ <= once_sent_) {
    counters_.add("pieces.sent_again");
  } else if (!sample_ && entry.is_urgent) {
    sample_ = Sample{entry.end, now};
  }
  once_sent_ = std::max(once_sent_, next_);
  highest_sent_ = std::max(highest_sent_, entry.end);
  return entry.is_urgent;
}

void Relay::check(Time now) {
  const Duration patience = awaits_urgently() ? std::max(patience_, 2 * ack_time_) : longest_patience;
  if (!met_ || next_ == 0 || now - progress_ < patience) return;
  patience_ = std::min(2 * patience_, longest_patience);
  rewind(now);
}

bool Relay::awaits_urgently() const {
  return std::any_of(chunks_.begin(), chunks_.begin() + static_cast<std::ptrdiff_t>(next_),
                     [](const Entry& each) { return each.is_urgent; });
}

void Relay::rewind(Time now) {
  rewound_ = now;
  send_all_again();
}

void Relay::send_all_again() {
  next_ = 0;
  sample_.reset();
}

}  // namespace arkmesh::gateway
