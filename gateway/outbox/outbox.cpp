// Lists of encoded messages, oldest first, with one replaceable entry per `latest` channel.
#include "gateway/outbox/outbox.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "gateway/frame/frame.hpp"

namespace arkmesh::gateway {

Outbox::Channel& Outbox::channel(std::string_view name) {
  const auto found = channels_.find(name);
  return found != channels_.end() ? found->second : channels_[std::string(name)];
}

std::size_t Outbox::waiting_messages() const {
  std::size_t all = held_;
  for (const Entries& lane : waiting_) all += lane.size();
  return all;
}

// To the end of its lane, out of a list that may be the lane itself.
void Outbox::enqueue(Entries& from, Entries::iterator entry) {
  Channel& of = *entry->channel;
  const bool is_long = entry->frames.size() > max_frame_bytes || of.long_ones > 0;
  of.long_ones += is_long;
  entry->lane = is_long ? of_long : of_short;
  Entries& to = waiting_[entry->lane];
  to.splice(to.end(), from, entry);
  if (entry->delivery == Delivery::latest) {
    of.waiting = entry;
    of.has_waiting = true;
  }
}

void Outbox::erase(Entries& from, Entries::iterator entry) {
  Channel& of = *entry->channel;
  if (&from == &leaving_ || &from == &in_flight_) {
    --of.in_flight;
  } else if (&from == &of.held) {
    --of.queued;
    --held_;
  } else {
    if (of.has_waiting && of.waiting == entry) of.has_waiting = false;
    of.long_ones -= entry->lane == of_long;
    if (entry->handed_out > 0) cut_ = false;
    --of.queued;
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
  const auto look = [&](Entries& list) {
    const auto found = std::ranges::find_if(
        list, [&](const Entry& entry) { return entry.delivery == victim && entry.handed_out == 0; });
    if (found == list.end() || (from && oldest->number < found->number)) return;
    from = &list;
    oldest = found;
  };
  for (Entries& lane : waiting_) look(lane);
  if (held_ > 0)
    for (auto& [name, each] : channels_) look(each.held);
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

bool Outbox::put(const Rule& rule, std::span<const std::byte> bytes, Time now) {
  Channel& to = channel(rule.channel);
  ++to.accepted;
  to.rule = rule;
  to.denied = false;
  const bool ordered = rule.delivery == Delivery::ordered;
  Entry made{.channel = &to, .delivery = rule.delivery, .message_bytes = bytes.size()};
  if (bytes.size() <= longest_) made.frames = encode_message(rule.channel, bytes, ordered ? to.sequence + 1 : 0);
  if (bytes.size() > longest_ || cost(made) > limit_) {
    ++to.refused;
    return false;
  }
  if (!ordered && to.has_waiting) {
    ++to.replaced;
    const auto place = to.waiting;
    const std::size_t others = bytes_ - cost(*place);
    if (others + cost(made) <= limit_ && (place->lane == of_long || made.frames.size() <= max_frame_bytes)) {
      bytes_ = others + cost(made);
      place->frames = std::move(made.frames);
      place->message_bytes = made.message_bytes;
      return true;
    }
    erase(waiting_[place->lane], place);  // the newer one is larger and takes its chance like any other
  } else if (!ordered && !to.held.empty() && to.held.back().delivery == Delivery::latest) {
    ++(!to.is_paced() ? to.replaced : to.over_bytes ? to.over_budget : to.rate_limited);
    erase(to.held, std::prev(to.held.end()));
  }
  if (!make_room(cost(made))) {
    ++to.dropped;
    return false;
  }
  bytes_ += cost(made);
  made.number = ++numbers_;
  if (ordered) {
    ++to.sequence;
    ++ordered_accepted_;
    ++ordered_pending_;
  }
  const bool goes = to.held.empty() && to.may_go(now);
  ++to.queued;
  Entries one;
  one.push_back(std::move(made));
  if (goes) {
    enqueue(one, one.begin());
  } else {
    ++held_;
    to.held.splice(to.held.end(), one);
  }
  return true;
}

// Sends what was held back on its way, when its time has come.
void Outbox::release(Time now) {
  if (held_ == 0) return;
  for (auto& [name, each] : channels_)
    while (!each.held.empty() && each.may_go(now)) {
      --held_;
      enqueue(each.held, each.held.begin());
    }
}

std::optional<Outbox::Time> Outbox::next_release() const {
  std::optional<Time> first;
  if (held_ > 0)
    for (const auto& [name, each] : channels_)
      if (!each.held.empty() && !each.is_in_lane() && (!first || each.next < *first)) first = each.next;
  return first;
}

// Whose first message goes next.
std::optional<Outbox::Lane> Outbox::choose() const {
  const bool has_short = !waiting_[of_short].empty(), has_long = !waiting_[of_long].empty();
  if (!has_short && !has_long) return {};
  return has_short && !(has_long && ahead_ >= max_frame_bytes) ? of_short : of_long;
}

// Of what waits, and of which nothing was handed out.
template <class Condition>
void Outbox::drop_waiting(Condition condition, std::uint64_t Channel::*reason) {
  const auto look = [&](Entries& list) {
    for (auto entry = list.begin(); entry != list.end();) {
      const auto candidate = entry++;
      if (candidate->handed_out > 0 || !condition(*candidate)) continue;
      ++(candidate->channel->*reason);
      erase(list, candidate);
    }
  };
  for (Entries& lane : waiting_) look(lane);
  for (auto& [name, each] : channels_) look(each.held);
}

void Outbox::set_longest(std::size_t message_bytes) {
  longest_ = message_bytes;
  drop_waiting([this](const Entry& entry) { return entry.message_bytes > longest_; }, &Channel::refused);
}

void Outbox::keep_only(const Link::Passes& passes) {
  for (auto& [name, each] : channels_) {
    each.denied = !passes(name);
    if (each.denied) forget_newest(each);
  }
  drop_waiting([](const Entry& entry) { return entry.channel->denied; }, &Channel::denials);
}

std::vector<std::span<const std::byte>> Outbox::batch(std::size_t max_frames, std::size_t max_bytes, Time now) {
  std::vector<std::span<const std::byte>> parts;
  std::size_t bytes = 0;
  release(now);
  while (parts.size() < max_frames && bytes < max_bytes) {
    const std::optional<Lane> next = choose();
    if (!next) break;
    const Entry& first = waiting_[*next].front();
    const std::size_t frame = std::min(max_frame_bytes, first.frames.size() - first.handed_out);
    if (!parts.empty() && bytes + frame > max_bytes) break;
    const bool passes_long_ones = next == of_short && !waiting_[of_long].empty();
    ahead_ = passes_long_ones ? ahead_ + frame : 0;
    bytes += frame;
    parts.push_back(hand_out(*next, frame, now));
  }
  return parts;
}

std::span<const std::byte> Outbox::whole_message(Time now) {
  release(now);
  const std::optional<Lane> next = choose();
  return next ? hand_out(*next, waiting_[*next].front().frames.size(), now) : std::span<const std::byte>();
}

// So many bytes of the lane's first message.
std::span<const std::byte> Outbox::hand_out(Lane from, std::size_t bytes, Time now) {
  Entries& lane = waiting_[from];
  Entry& entry = lane.front();
  Channel& of = *entry.channel;
  const auto out = std::span<const std::byte>(entry.frames).subspan(entry.handed_out, bytes);
  entry.handed_out += bytes;
  handed_out_ += bytes;
  // Under way: a newer one queues behind it instead of changing it.
  if (of.has_waiting && &*of.waiting == &entry) of.has_waiting = false;
  if (from == of_long) cut_ = entry.handed_out < entry.frames.size();
  if (entry.handed_out < entry.frames.size()) return out;
  --of.queued;
  ++of.in_flight;
  of.long_ones -= from == of_long;
  entry.end = handed_out_;
  if (of.is_paced()) pace(of, entry.message_bytes, now);
  leaving_.splice(leaving_.end(), lane, lane.begin());
  return out;
}

// A message of so many bytes has gone: when the next may.
void Outbox::pace(Channel& of, std::size_t bytes, Time now) {
  const double for_message_s = 1 / of.rule.rate_hz, for_bytes_s = static_cast<double>(bytes) / of.rule.bytes_per_s;
  of.over_bytes = for_bytes_s > for_message_s;
  of.next =
      std::max(of.next, now - catch_up) +
      std::chrono::duration_cast<Time::duration>(std::chrono::duration<double>(std::max(for_message_s, for_bytes_s)));
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
  if (cut_) {
    Entries& lane = waiting_[of_long];
    if (lane.front().delivery == Delivery::latest)
      lose(lane, lane.begin());
    else
      lane.front().handed_out = 0;
    cut_ = false;
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
  const auto gather = [&](Entries& from) {
    from.sort(older);
    all.merge(from, older);
  };
  gather(in_flight_);
  for (Entries& lane : waiting_) gather(lane);
  written_ = handed_out_;
  ahead_ = 0;
  for (auto& [name, each] : channels_) each.long_ones = 0;
  while (!all.empty()) enqueue(all, all.begin());
  drop_waiting([](const Entry& entry) { return entry.channel->denied; }, &Channel::denials);
}

void Outbox::send_again(bool also_what_arrived) {
  for (auto& [name, each] : channels_) {
    if (each.denied) forget_newest(each);
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
    set("dropped.rate_limited", name, channel.rate_limited);
    set("dropped.over_budget", name, channel.over_budget);
    set("dropped.denied", name, channel.denials);
    set("refused.too_big", name, channel.refused);
  }
  all.set("outbox.waiting.messages", waiting_messages() + leaving_.size());
  all.set("outbox.waiting.bytes", bytes_);
  return all;
}

}  // namespace arkmesh::gateway
