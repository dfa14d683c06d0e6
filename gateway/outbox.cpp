// A list of encoded messages, oldest first, with one replaceable entry per `latest` channel.
#include "gateway/outbox.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace arkmesh::gateway {

Outbox::Channel& Outbox::channel(std::string_view name) {
  auto found = channels_.find(name);
  if (found == channels_.end()) {
    found = channels_.emplace(std::string(name), Channel{}).first;
    found->second.name = found->first;
  }
  return found->second;
}

void Outbox::erase(Entries::iterator entry) {
  if (entry->channel->has_waiting && entry->channel->waiting == entry) entry->channel->has_waiting = false;
  bytes_ -= cost(*entry);
  entries_.erase(entry);
}

bool Outbox::make_room(std::size_t wanted) {
  // Two rounds: `ordered` messages go before `latest` ones, which are the newest of their kind.
  for (Delivery victim : {Delivery::ordered, Delivery::latest}) {
    auto entry = std::next(entries_.begin(), static_cast<std::ptrdiff_t>(handed_out_));
    while (bytes_ + wanted > limit_ && entry != entries_.end()) {
      const auto oldest = entry++;
      if (oldest->delivery != victim) continue;
      ++oldest->channel->dropped;
      erase(oldest);
    }
  }
  return bytes_ + wanted <= limit_;
}

bool Outbox::put(Delivery delivery, std::string_view name, std::vector<std::byte> message) {
  Channel& to = channel(name);
  Entry entry{&to, delivery, std::move(message)};
  if (cost(entry) > limit_ || entry.message.size() > longest_) {
    ++to.refused;
    return false;
  }
  if (delivery == Delivery::latest && to.has_waiting) {
    ++to.replaced;
    const auto place = to.waiting;
    const std::size_t others = bytes_ - cost(*place);
    if (others + cost(entry) <= limit_) {
      bytes_ = others + cost(entry);
      place->message = std::move(entry.message);
      return true;
    }
    erase(place);  // the newer one is larger and takes its chance like any other
  }
  if (!make_room(cost(entry))) {
    ++to.dropped;
    return false;
  }
  bytes_ += cost(entry);
  entries_.push_back(std::move(entry));
  if (delivery == Delivery::latest) {
    to.waiting = std::prev(entries_.end());
    to.has_waiting = true;
  }
  return true;
}

void Outbox::set_longest(std::size_t message_bytes) {
  longest_ = message_bytes;
  auto entry = std::next(entries_.begin(), static_cast<std::ptrdiff_t>(handed_out_));
  while (entry != entries_.end()) {
    const auto candidate = entry++;
    if (candidate->message.size() <= longest_) continue;
    ++candidate->channel->refused;
    erase(candidate);
  }
}

std::vector<std::span<const std::byte>> Outbox::batch(std::size_t max_messages, std::size_t max_bytes) {
  std::vector<std::span<const std::byte>> parts;
  std::size_t bytes = 0;
  handed_out_ = 0;
  for (Entry& entry : entries_) {
    std::span<const std::byte> part(entry.message);
    if (parts.empty())
      part = part.subspan(first_written_);
    else if (parts.size() == max_messages || bytes + part.size() > max_bytes)
      break;
    bytes += part.size();
    parts.push_back(part);
    ++handed_out_;
    // Under way: a newer one queues behind it instead of changing it.
    if (entry.channel->has_waiting && &*entry.channel->waiting == &entry) entry.channel->has_waiting = false;
  }
  return parts;
}

Outbox::Written Outbox::written(std::size_t bytes) {
  Written complete;
  while (bytes > 0 && !entries_.empty()) {
    const std::size_t rest = entries_.front().message.size() - first_written_;
    if (bytes < rest) {
      first_written_ += bytes;
      break;
    }
    bytes -= rest;
    first_written_ = 0;
    ++complete.messages;
    complete.bytes += entries_.front().message.size() - entries_.front().channel->name.size();
    erase(entries_.begin());
  }
  // Of the rest only the one that is partly written must stay as it is.
  take_back(handed_out_ - complete.messages, first_written_ > 0 ? 1 : 0);
  return complete;
}

void Outbox::rewind() {
  first_written_ = 0;
  take_back(handed_out_, 0);
}

void Outbox::take_back(std::size_t from, std::size_t down_to) {
  handed_out_ = std::min(from, down_to);
  auto entry = std::next(entries_.begin(), static_cast<std::ptrdiff_t>(from));
  // Newest first, so that of one channel the newest stays.
  for (; from > down_to; --from) {
    const auto candidate = --entry;
    if (candidate->delivery != Delivery::latest) continue;
    Channel& of = *candidate->channel;
    if (of.has_waiting) {
      ++of.replaced;
      entry = std::next(candidate);
      erase(candidate);
    } else {
      of.waiting = candidate;
      of.has_waiting = true;
    }
  }
}

hal::Counters Outbox::counters() const {
  hal::Counters all;
  for (const auto& [name, channel] : channels_) {
    if (channel.replaced) all.add("outbox.replaced." + name, channel.replaced);
    if (channel.dropped) all.add("outbox.dropped.full." + name, channel.dropped);
    if (channel.refused) all.add("outbox.refused.too_big." + name, channel.refused);
  }
  return all;
}

}  // namespace arkmesh::gateway
