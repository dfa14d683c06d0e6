#include "gateway/federation/federation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <cassert>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "gateway/federation/federation_stream.hpp"
#include "hal/arenas/messages.hpp"

namespace arkmesh::gateway {

namespace asio = boost::asio;
using boost::system::error_code;
using namespace std::chrono_literals;

namespace {

constexpr std::chrono::milliseconds tick_period{20}, keys_period{2000};
// Who is not met is asked for so often, and by more labs, which all hear it and answer, less often.
constexpr std::chrono::milliseconds least_ask_period{200}, ask_period_per_peer{20};
// Of a message to all a lab hears an acknowledgement from each. The more there are, the longer they wait for further
// messages, until twenty labs: so many a second are heard then, and more only of more labs.
constexpr int most_acks_per_s = 100;
constexpr std::chrono::milliseconds longest_ack_time{200};
constexpr std::chrono::milliseconds watched_period{200};  // of each channel a message
constexpr std::size_t most_seen = 4096;                   // packets; those of two subjects overtake each other
constexpr int arena_each = 10;                            // periods, at least, the arena's among them
// A packet is no longer, and more does not wait for the server.
constexpr std::size_t most_packet_bytes = 256 << 10, most_waiting_bytes = 1 << 20;

}  // namespace

Federation::Federation(asio::io_context& io, FederationSettings settings)
    : io_(io),
      settings_(std::move(settings)),
      root_(subject_root(settings_.experiment)),
      keys_(settings_.lab, settings_.experiment, settings_.boot_id, settings_.keys),
      timer_(io) {
  assert(settings_.keys && "members of a federation have keys");
  NatsSettings nats;
  nats.servers = settings_.servers;
  nats.name = fmt::format("arkmesh gateway of {}", settings_.lab);
  nats.server_ca = settings_.options.server_ca;
  nats.credentials = settings_.options.credentials;
  nats.subjects = {fmt::format("{}.*.{}", root_, to_all), fmt::format("{}.*.{}", root_, settings_.lab)};
  nats.longest_retry = settings_.longest_retry;
  nats.own_subject = fmt::format("{}.{}.ECHO", root_, settings_.lab);
  connection_ = std::make_unique<NatsConnection>(
      io_, std::move(nats),
      NatsConnection::Events{
          .up = [this] { came_up(); },
          .down = [this] { went_down(); },
          .arrived = [this](std::vector<NatsConnection::Message> messages) { take(std::move(messages)); },
          .writable = [this] { flush_soon(); },
      });
  tick();
}

Federation::~Federation() = default;

void Federation::watch(std::string_view channel, std::span<const std::byte> bytes) {
  auto found = watched_.find(channel);
  if (found == watched_.end()) found = watched_.emplace(channel, Newest{}).first;
  found->second.bytes.assign(bytes.begin(), bytes.end());
  found->second.is_fresh = true;
}

std::unique_ptr<SocketStream> Federation::stream(const std::string& peer) {
  return std::make_unique<Stream>(*this, peer);
}

hal::Counters Federation::counters() const {
  hal::Counters all = counters_;
  all.merge(keys_.counters());
  all.merge(connection_->counters());
  for (const auto& [peer, stream] : streams_) all.merge(stream->relay.counters(), "federation.");
  return all;
}

void Federation::came_up() {
  asked_ = keys_sent_ = {};
  flush_soon();
}

// What was under way may not have arrived.
void Federation::went_down() {
  for (const auto& [peer, stream] : streams_) stream->relay.send_all_again();
}

void Federation::take(std::vector<NatsConnection::Message> messages) {
  std::vector<PacketView> all;
  for (const auto& [subject, bytes] : messages) {
    const auto packet = read_packet(bytes);
    if (!packet) {
      keys_.refuse("malformed");
      continue;
    }
    if (packet->head.from == settings_.lab) continue;  // our own
    if (is_watched(packet->head.kind)) {
      keys_.refuse("subject");
      continue;
    }
    const std::string theirs = fmt::format("{}.{}.", root_, packet->head.from);
    const bool sealed = packet->head.kind == PacketKind::sealed;
    if (subject == theirs + (sealed ? settings_.lab : std::string(to_all)))
      all.push_back(*packet);
    else
      keys_.refuse("subject");
  }
  // Those of two subjects come one subject after the other.
  std::ranges::stable_sort(all, {}, [](const PacketView& each) {
    return std::tuple(std::string_view(each.head.from), each.head.boot_id, each.head.number);
  });
  for (const PacketView& each : all) take(each);
  if (const std::string notice = keys_.take_notice(); settings_.notice && !notice.empty()) settings_.notice(notice);
}

void Federation::take(const PacketView& packet) {
  const std::string& from = packet.head.from;
  if (!streams_.contains(from))
    return keys_.trusts(from) ? counters_.add("federation.ignored.no_stream") : keys_.refuse("not_trusted");
  // Who repeats what was said costs no look at a signature, once it was looked at.
  std::set<PacketOrder>& seen = streams_.at(from)->seen;
  const PacketOrder at = order_of(packet.head);
  if (seen.contains(at) || (seen.size() == most_seen && at < *seen.begin())) return keys_.refuse("repeated", from);
  const auto note = [&] {
    if (seen.size() == most_seen) seen.erase(seen.begin());
    seen.insert(at);
  };
  if (packet.head.kind == PacketKind::keys)
    return keys_.is_signed(packet) ? note(), keys_.take_group_key(packet) : void();
  const auto plain = keys_.open(packet);
  if (!plain) return;
  const auto body = read_body(*plain);
  if (!body) return keys_.refuse("malformed", from);
  // What is for others only is not worth a look at its signature.
  if (!is_for_us(from, *body)) return;
  if (packet.head.kind != PacketKind::sealed && !keys_.is_signed(packet)) return;
  note();
  take(from, at, *body);
}

bool Federation::is_for_us(const std::string& from, const PacketBody& body) const {
  const StreamId ours = streams_.at(from)->relay.mine();
  const auto names_us = [&](const auto& each) { return each.yours == ours; };
  return std::ranges::any_of(body.greetings, [&](const Greeting& each) { return each.to == settings_.lab; }) ||
         std::ranges::any_of(body.pieces, names_us) || std::ranges::any_of(body.endings, names_us);
}

// Verified, and some of it for us.
void Federation::take(const std::string& from, PacketOrder at, const PacketBody& body) {
  const auto now = std::chrono::steady_clock::now();
  Stream& stream = *streams_.at(from);
  for (const Greeting& each : body.greetings)
    if (each.to == settings_.lab && stream.relay.hear(each, at)) {
      stream.answer_to = each.mine;
      keys_wanted_ = true;
      flush_soon();
    }
  for (const Piece& each : body.pieces)
    if (each.yours == stream.relay.mine() && !stream.relay.take(each, body, at, now))
      keys_.refuse("acknowledgement", from);
  for (const Ending& each : body.endings)
    if (each.yours == stream.relay.mine()) stream.relay.hear(each);
  if (stream.relay.owes_answer(now) || stream.relay.next()) flush_soon();
  const StreamId of = stream.relay.mine();
  stream.look();
  deliver(from, of);
}

void Federation::deliver(const std::string& peer, StreamId of) {
  if (const auto found = streams_.find(peer); found != streams_.end() && found->second->relay.mine() == of)
    found->second->deliver();
}

// One for all peers that the same bytes are written to in one turn of the loop.
ChunkPointer Federation::chunk(std::span<const std::byte> bytes, bool is_message) {
  if (is_message)
    for (const ChunkPointer& each : fresh_)
      if (std::ranges::equal(each->bytes, bytes)) return each;
  auto made = std::make_shared<const Chunk>(Chunk{{bytes.begin(), bytes.end()}, is_message});
  if (is_message) fresh_.push_back(made);
  return made;
}

void Federation::flush_soon() {
  if (std::exchange(flush_posted_, true)) return;
  asio::post(io_, [this, alive = std::weak_ptr(alive_)] {
    if (alive.expired()) return;
    flush_posted_ = false;
    flush();
  });
}

void Federation::flush() {
  fresh_.clear();
  if (!connection_->up() || is_congested()) return;
  const auto now = std::chrono::steady_clock::now();
  if (are_keys_due(now)) send_keys();
  if (now - asked_ >= ask_period()) ask();
  for (const auto& [peer, stream] : streams_)
    if (const auto answer = std::exchange(stream->answer_to, {}))
      send_to(*stream, now, {stream->relay.greeting(peer, *answer)});
  send_fresh_messages(now);
  if (now - watched_sent_ >= watched_period) {
    watched_sent_ = now;
    send_watched();
  }
  for (const auto& [peer, stream] : streams_)
    if (stream->relay.met() && (stream->relay.next() || stream->relay.owes_answer(now))) send_to(*stream, now);
}

Relay::Duration Federation::ask_period() const {
  return std::max(least_ask_period, static_cast<int>(streams_.size()) * ask_period_per_peer);
}

Relay::Duration Federation::ack_time() const {
  const Relay::Duration wanted = Relay::Duration(1000) * static_cast<int>(streams_.size()) / most_acks_per_s;
  return std::clamp(wanted, Relay::least_ack_time, longest_ack_time);
}

// Who has not been met is asked for.
void Federation::ask() {
  PacketBody body;
  for (const auto& [peer, stream] : streams_)
    if (!stream->relay.met()) body.greetings.push_back(stream->relay.greeting(peer, stream->relay.yours()));
  if (body.greetings.empty()) return;
  asked_ = std::chrono::steady_clock::now();
  publish_to_all(keys_.for_all(PacketKind::signed_open, encode_body(body)));
}

// Who repeats a newcomer's greetings does not make us say them more often than somebody who has come asks.
bool Federation::are_keys_due(Time now) const {
  if (!settings_.options.encrypt) return false;
  return now - keys_sent_ >= (keys_wanted_ ? Time::duration(ask_period()) : Time::duration(keys_period)) ||
         keys_.group_key_is_stale();
}

void Federation::send_keys() {
  keys_sent_ = std::chrono::steady_clock::now();
  keys_wanted_ = false;
  const auto packet = keys_.group_key_for_all();
  publish_to_all(packet);
  connection_->publish(fmt::format("{}.{}.{}", root_, settings_.lab, to_watchers), packet);
}

// One packet for all, in which what several get is once.
void Federation::send_fresh_messages(Time now) {
  std::vector<Stream*> to;
  for (const auto& [peer, stream] : streams_)
    if (stream->relay.met() && !stream->relay.sends_again() && stream->relay.has_fresh_message()) to.push_back(stream);
  while (std::ranges::any_of(to, [](Stream* each) { return each->relay.next() != nullptr; })) {
    PacketBody body;
    std::vector<ChunkPointer> held;
    std::map<const Chunk*, std::uint16_t> numbers;
    const std::size_t most = room() - std::min(room() / 2, to.size() * 2 * piece_bytes);
    std::size_t bytes = 0;
    for (Stream* const stream : to) {
      Relay& relay = stream->relay;
      if (!relay.next()) continue;
      Piece piece = relay.piece();
      while (const Chunk* const next = relay.next()) {
        const auto known = numbers.find(next);
        const bool is_new = known == numbers.end();
        const std::size_t size = sizeof(std::uint16_t) + (is_new ? next->bytes.size() + sizeof(std::uint32_t) : 0);
        if (!held.empty() && (bytes + size > most || (is_new && held.size() == max_packet_entries))) break;
        bytes += size;
        piece.chunks.push_back(is_new ? static_cast<std::uint16_t>(held.size()) : known->second);
        if (is_new) {
          numbers.emplace(next, static_cast<std::uint16_t>(held.size()));
          held.push_back(relay.share_next());
          body.chunks.emplace_back(next->bytes);
        }
        piece.is_urgent |= relay.sent(now);
      }
      body.pieces.push_back(std::move(piece));
    }
    const PacketKind kind = settings_.options.encrypt ? PacketKind::signed_secret : PacketKind::signed_open;
    publish_to_all(keys_.for_all(kind, encode_body(body)));
  }
}

void Federation::send_to(Stream& stream, Time now, std::vector<Greeting> greetings, bool ends) {
  Relay& relay = stream.relay;
  bool more = true;
  for (PacketBody body{.greetings = std::move(greetings)}; more; body = {}) {
    std::vector<ChunkPointer> held;
    std::size_t bytes = 0;
    if (relay.met()) {
      Piece piece = relay.piece();
      while (const Chunk* const next = relay.next()) {
        const std::size_t size = next->bytes.size() + sizeof(std::uint32_t) + sizeof(std::uint16_t);
        if (!held.empty() && (bytes + size > room() || held.size() == max_packet_entries)) break;
        piece.chunks.push_back(static_cast<std::uint16_t>(held.size()));
        held.push_back(relay.share_next());
        body.chunks.emplace_back(next->bytes);
        bytes += size;
        piece.is_urgent |= relay.sent(now);
      }
      body.pieces.push_back(std::move(piece));
    }
    more = relay.met() && relay.next() != nullptr;
    if (ends && !more) body.endings.push_back({relay.yours(), relay.mine()});
    publish_sealed(stream.peer_name(), body);
  }
}

// Whether somebody watches nobody knows; it costs the same for none and for a hundred.
void Federation::send_watched() {
  std::vector<Watched> messages;
  std::size_t bytes = 0;
  const auto send = [&] {
    if (messages.empty()) return;
    const PacketKind kind = settings_.options.encrypt ? PacketKind::watched_secret : PacketKind::watched_open;
    connection_->publish(fmt::format("{}.{}.{}", root_, settings_.lab, to_watchers),
                         keys_.for_all(kind, encode_watched(messages)));
    messages.clear();
    bytes = 0;
  };
  // A lab seldom says what its arena is like; who begins to watch hears it soon, as long as the lab says anything.
  const bool says_again = ++watched_rounds_ % arena_each == 0 &&
                          std::ranges::any_of(watched_, [](const auto& each) { return each.second.is_fresh; });
  for (auto& [channel, newest] : watched_) {
    if (!std::exchange(newest.is_fresh, false) && !(says_again && channel == hal::channel::arena)) continue;
    const std::size_t size = newest.bytes.size() + channel.size() + sizeof(std::uint32_t) + 1;
    if (size > room()) {
      counters_.add("federation.watched.too_big." + channel);
      continue;
    }
    if (bytes + size > room()) send();
    messages.push_back({channel, newest.bytes});
    bytes += size;
  }
  send();
}

std::size_t Federation::room() const {
  const std::size_t all = std::min(connection_->max_payload(), most_packet_bytes);
  const std::size_t around = packet_overhead_bytes + signature_bytes + seal_bytes;
  return all > around ? all - around : 0;
}

bool Federation::is_congested() const {
  return connection_->waiting_bytes() > most_waiting_bytes;
}

void Federation::publish_to_all(const std::vector<std::byte>& packet) {
  connection_->publish(fmt::format("{}.{}.{}", root_, settings_.lab, to_all), packet);
}

// Who was revoked since gets nothing; the session ends at its next check.
void Federation::publish_sealed(const std::string& to, const PacketBody& body) {
  if (const auto packet = keys_.for_one(to, encode_body(body)))
    connection_->publish(fmt::format("{}.{}.{}", root_, settings_.lab, to), *packet);
}

void Federation::tick() {
  const auto now = std::chrono::steady_clock::now();
  bool wanted = are_keys_due(now);
  wanted |= !watched_.empty() && now - watched_sent_ >= watched_period;
  for (const auto& [peer, stream] : streams_) {
    Relay& relay = stream->relay;
    relay.acknowledge_within(ack_time());
    relay.check(now);
    wanted |= relay.met() ? relay.next() || relay.owes_answer(now) : now - asked_ >= ask_period();
  }
  if (wanted) flush_soon();
  timer_.expires_after(tick_period);
  timer_.async_wait([this, alive = std::weak_ptr(alive_)](error_code error) {
    if (!error && !alive.expired()) tick();
  });
}

}  // namespace arkmesh::gateway
