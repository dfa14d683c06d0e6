// Lists of encoded messages, oldest first, with one replaceable entry per `latest` channel.
#include "gateway/outbox.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "gateway/frame.hpp"

namespace arkmesh::gateway {

Outbox::Channel& Outbox::channel(std::string_view name) {
  const auto found = channels_.find(name);
  return found != channels_.end() ? found->second : channels_[std::string(name)];
}

// To the end of its lane, out of a list that may be the lane itself.
void Outbox::enqueue(Entries& from, Entries::iterator entry) {
  Channel& of = *entry->channel;
  entry->lane = entry->frames.size() > max_frame_bytes || of.long_ones > 0 ? 1 : 0;
  of.long_ones += entry->lane;
  Entries& to = waiting_[entry->lane];
  to.splice(to.end(), from, entry);
  if (entry->delivery == Delivery::latest) {
    of.waiting = entry;
    of.has_waiting = true;
  }
}

void Outbox::erase(Entries& from, Entries::iterator entry) {
  Channel& of = *entry->channel;
  if (&from == &waiting_[0] || &from == &waiting_[1]) {
    if (of.has_waiting && of.waiting == entry) of.has_waiting = false;
    of.long_ones -= entry->lane;
    --of.queued;
  } else {
    --of.in_flight;
  }
  if (entry->delivery == Delivery::ordered) --ordered_pending_;
  bytes_ -= cost(*entry);
  from.erase(entry);
}

void Outbox::forget_newest(Channel& of) {
  bytes_ -= of.newest.capacity();
  std::vector<std::byte>().swap(of.newest);
}

// The oldest of its kind that waits and of which nothing was handed out.
bool Outbox::drop_oldest(Delivery victim) {
  Entries* from = nullptr;
  Entries::iterator oldest;
  for (Entries& lane : waiting_) {
    const auto found = std::ranges::find_if(
        lane, [&](const Entry& entry) { return entry.delivery == victim && entry.handed_out == 0; });
    if (found == lane.end() || (from && oldest->number < found->number)) continue;
    from = &lane;
    oldest = found;
  }
  if (!from) return false;
  ++oldest->channel->dropped;
  erase(*from, oldest);
  return true;
}

bool Outbox::make_room(std::size_t wanted) {
  for (auto& [name, each] : channels_)
    if (bytes_ + wanted > limit_) forget_newest(each);
  // `ordered` messages go before `latest` ones, which are the newest of their kind.
  for (const Delivery victim : {Delivery::ordered, Delivery::latest})
    while (bytes_ + wanted > limit_ && drop_oldest(victim)) continue;
  return bytes_ + wanted <= limit_;
}

bool Outbox::put(Delivery delivery, std::string_view name, std::span<const std::byte> bytes) {
  Channel& to = channel(name);
  ++to.accepted;
  const bool ordered = delivery == Delivery::ordered;
  Entry made{.channel = &to, .delivery = delivery, .message_bytes = bytes.size()};
  if (bytes.size() <= longest_) made.frames = encode_message(name, bytes, ordered ? to.sequence + 1 : 0);
  if (bytes.size() > longest_ || cost(made) > limit_) {
    ++to.refused;
    return false;
  }
  if (!ordered && to.has_waiting) {
    ++to.replaced;
    const auto place = to.waiting;
    const std::size_t others = bytes_ - cost(*place);
    if (others + cost(made) <= limit_ && (place->lane == 1 || made.frames.size() <= max_frame_bytes)) {
      bytes_ = others + cost(made);
      place->frames = std::move(made.frames);
      place->message_bytes = made.message_bytes;
      return true;
    }
    erase(waiting_[place->lane], place);  // the newer one is larger and takes its chance like any other
  }
  if (!make_room(cost(made))) {
    ++to.dropped;
    return false;
  }
  bytes_ += cost(made);
  made.number = ++numbers_;
  ++to.queued;
  if (ordered) {
    ++to.sequence;
    ++ordered_accepted_;
    ++ordered_pending_;
  }
  Entries one;
  one.push_back(std::move(made));
  enqueue(one, one.begin());
  return true;
}

void Outbox::set_longest(std::size_t message_bytes) {
  longest_ = message_bytes;
  for (Entries& lane : waiting_)
    for (auto entry = lane.begin(); entry != lane.end();) {
      const auto candidate = entry++;
      if (candidate->message_bytes <= longest_ || candidate->handed_out > 0) continue;
      ++candidate->channel->refused;
      erase(lane, candidate);
    }
}

std::vector<std::span<const std::byte>> Outbox::batch(std::size_t max_frames, std::size_t max_bytes) {
  std::vector<std::span<const std::byte>> parts;
  std::size_t bytes = 0;
  while (parts.size() < max_frames && bytes < max_bytes && waiting_messages() > 0) {
    const bool second = waiting_[0].empty() || (!waiting_[1].empty() && ahead_ >= max_frame_bytes);
    Entries& lane = waiting_[second ? 1 : 0];
    const std::size_t frame = std::min(max_frame_bytes, lane.front().frames.size() - lane.front().handed_out);
    if (!parts.empty() && bytes + frame > max_bytes) break;
    ahead_ = second || waiting_[1].empty() ? 0 : ahead_ + frame;
    bytes += frame;
    parts.push_back(hand_out(lane, frame));
  }
  return parts;
}

std::span<const std::byte> Outbox::whole_message() {
  if (waiting_messages() == 0) return {};
  Entries& lane = waiting_[waiting_[0].empty() ? 1 : 0];
  return hand_out(lane, lane.front().frames.size());
}

// So many bytes of the lane's first message.
std::span<const std::byte> Outbox::hand_out(Entries& lane, std::size_t bytes) {
  Entry& entry = lane.front();
  Channel& of = *entry.channel;
  const auto out = std::span<const std::byte>(entry.frames).subspan(entry.handed_out, bytes);
  entry.handed_out += bytes;
  handed_out_ += bytes;
  // Under way: a newer one queues behind it instead of changing it.
  if (of.has_waiting && &*of.waiting == &entry) of.has_waiting = false;
  if (entry.handed_out < entry.frames.size()) return out;
  --of.queued;
  ++of.in_flight;
  of.long_ones -= entry.lane;
  entry.end = handed_out_;
  leaving_.splice(leaving_.end(), lane, lane.begin());
  return out;
}

Outbox::Sent Outbox::written(std::size_t bytes) {
  Sent sent;
  written_ += bytes;
  while (!leaving_.empty() && leaving_.front().end <= written_) {
    ++sent.messages;
    sent.bytes += leaving_.front().message_bytes;
    in_flight_.splice(in_flight_.end(), leaving_, leaving_.begin());
  }
  return sent;
}

// Of `latest`: it is over for this entry, but its message may be wanted again.
void Outbox::keep_newest(Entries& from, Entries::iterator entry, bool arrived) {
  Channel& of = *entry->channel;
  forget_newest(of);
  of.newest_bytes = entry->message_bytes;
  of.newest_arrived = arrived;
  std::vector<std::byte> frames = std::move(entry->frames);
  bytes_ -= frames.capacity();
  erase(from, entry);
  bytes_ += frames.capacity();
  of.newest = std::move(frames);
}

bool Outbox::acknowledged(std::size_t messages) {
  if (messages > in_flight_.size()) return false;
  for (; messages > 0; --messages) {
    const auto entry = in_flight_.begin();
    ++entry->channel->acknowledged;
    if (entry->delivery == Delivery::latest)
      keep_newest(in_flight_, entry, true);
    else
      erase(in_flight_, entry);
  }
  return true;
}

void Outbox::session_lost() {
  const auto lose = [this](Entries& from, Entries::iterator entry) {
    ++entry->channel->lost;
    keep_newest(from, entry, false);
  };
  in_flight_.splice(in_flight_.end(), leaving_);
  for (auto entry = in_flight_.begin(); entry != in_flight_.end();)
    if (const auto each = entry++; each->delivery == Delivery::latest) lose(in_flight_, each);
  if (Entries& second = waiting_[1]; !second.empty() && second.front().handed_out > 0) {
    if (second.front().delivery == Delivery::latest)
      lose(second, second.begin());
    else
      second.front().handed_out = 0;
  }
  // All that is left in order of arrival, which is that of each channel; then each to its lane anew, for what waited in
  // the first may not overtake what comes back into the second.
  for (Entry& entry : in_flight_) {
    entry.handed_out = 0;
    --entry.channel->in_flight;
    ++entry.channel->queued;
  }
  const auto older = [](const Entry& a, const Entry& b) { return a.number < b.number; };
  Entries all;
  for (Entries* from : {&in_flight_, &waiting_[0], &waiting_[1]}) {
    from->sort(older);
    all.merge(*from, older);
  }
  written_ = handed_out_;
  ahead_ = 0;
  for (auto& [name, each] : channels_) each.long_ones = 0;
  while (!all.empty()) enqueue(all, all.begin());
}

void Outbox::send_again(bool also_what_arrived) {
  for (auto& [name, each] : channels_) {
    if (each.newest.empty() || (each.newest_arrived && !also_what_arrived)) continue;
    Entry again{.channel = &each, .message_bytes = each.newest_bytes, .frames = std::move(each.newest)};
    each.newest.clear();
    bytes_ -= again.frames.capacity();
    const bool has_newer = each.queued + each.in_flight > 0;
    if (has_newer || again.message_bytes > longest_ || bytes_ + cost(again) > limit_) continue;
    bytes_ += cost(again);
    again.number = ++numbers_;
    ++each.accepted;
    ++each.queued;
    Entries one;
    one.push_back(std::move(again));
    enqueue(one, one.begin());
  }
}

hal::Counters Outbox::counters() const {
  hal::Counters all;
  const auto set = [&all](const char* what, const std::string& name, std::uint64_t n) {
    if (n > 0) all.set(std::string("outbox.") + what + "." + name, n);
  };
  for (const auto& [name, channel] : channels_) {
    set("accepted", name, channel.accepted);
    set("acknowledged", name, channel.acknowledged);
    set("in_flight", name, channel.in_flight);
    set("queued", name, channel.queued);
    set("replaced", name, channel.replaced);
    set("dropped.full", name, channel.dropped);
    set("dropped.session_lost", name, channel.lost);
    set("refused.too_big", name, channel.refused);
  }
  all.set("outbox.waiting.messages", waiting_messages() + leaving_.size());
  all.set("outbox.waiting.bytes", bytes_);
  return all;
}

}  // namespace arkmesh::gateway
