#include "gateway/federation/federation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <cassert>
#include <optional>
#include <utility>

#include "gateway/frame.hpp"
#include "hal/config.hpp"

namespace arkmesh::gateway {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {

constexpr std::chrono::milliseconds tick_period{20}, ask_period{200}, keys_period{2000};
// A packet is no longer, and more does not wait for the server.
constexpr std::size_t most_packet_bytes = 256 << 10, most_waiting_bytes = 1 << 20;
// So many packets a second that a lab has not signed are looked at: each costs as much as one that it has. What the lab
// itself says then comes sealed, when it says it again.
constexpr double forgeries_per_s = 20;

std::chrono::microseconds microseconds(Relay::Time time) {
  return std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch());
}

void put_text(std::vector<std::byte>& out, std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  out.insert(out.end(), bytes.begin(), bytes.end());
  out.push_back(std::byte{0});
}

}  // namespace

class Federation::Stream final : public SocketStream {
 public:
  Stream(Federation& federation, std::string peer)
      : relay(new_unguessable_number()),
        federation_(&federation),
        io_(federation.io_),
        alive_(federation.alive_),
        peer_(std::move(peer)) {}
  ~Stream() override { leave(); }

  asio::any_io_executor executor() override { return io_.get_executor(); }

  void open(Opened opened) override {
    if (const StreamFailure failure = objection(); !failure.counter.empty()) return opened(failure);
    if (!federation_->connection_->up())
      return opened({"session.failed.server", federation_->connection_->why(), true});
    opened_ = std::move(opened);
    federation_->streams_[peer_] = this;
    federation_->asked_ = {};
    federation_->flush_soon();
  }

  void read(asio::mutable_buffer into, Done done) override {
    into_ = into;
    read_done_ = std::move(done);
    if (relay.unread().empty() && !relay.ended()) return;
    asio::post(executor(), [alive = std::weak_ptr(alive_), federation = federation_, peer = peer_, of = relay.mine()] {
      if (!alive.expired()) federation->deliver(peer, of);
    });
  }

  void write(std::span<const asio::const_buffer> from, Done done) override {
    const std::size_t bytes = try_write(from);
    asio::post(executor(), [done = std::move(done), bytes] { done({}, bytes); });
  }

  // All of it: how much is under way is the session's to limit.
  std::size_t try_write(std::span<const asio::const_buffer> from) override {
    std::size_t bytes = 0;
    for (const auto& each : from) {
      put(each);
      bytes += each.size();
    }
    federation_->flush_soon();
    return bytes;
  }
  void write_now(asio::const_buffer from) override { put(from); }
  void finish() override {
    if (relay.met() && !relay.ended()) federation_->send_to(*this, std::chrono::steady_clock::now(), {}, true);
  }
  void close() override {
    if (is_there() && relay.met() && !relay.ended())
      federation_->send_to(*this, std::chrono::steady_clock::now(), {}, true);
    leave();
    const auto aborted = make_error_code(asio::error::operation_aborted);
    // Whoever is in the midst of one of these may be all that keeps this stream.
    if (auto opened = std::exchange(opened_, {})) asio::post(executor(), [opened = std::move(opened)] {});
    if (auto done = std::exchange(read_done_, {}))
      asio::post(executor(), [done = std::move(done), aborted] { done(aborted, 0); });
  }

  std::string peer_name() const override { return peer_; }
  StreamFailure objection() const override {
    if (!federation_->settings_.keys->seals().of(peer_))
      return {"session.refused.not_trusted",
              fmt::format("the certificate of lab {0} is not trusted here, or was revoked; get its file and say: "
                          "arkmesh keys trust {0}.crt",
                          peer_)};
    return {};
  }
  std::string too_slow() const override { return "session.failed.connect"; }
  bool awaits_first_answer() const override { return true; }

  // The relay has heard something.
  void look() {
    if (relay.met())
      if (const auto opened = std::exchange(opened_, {})) opened({});
  }
  // Hands over what came.
  void deliver() {
    if (!read_done_ || (relay.unread().empty() && !relay.ended())) return;
    auto& unread = relay.unread();
    const std::size_t bytes = std::min(unread.size(), into_.size());
    std::copy_n(unread.begin(), bytes, static_cast<std::byte*>(into_.data()));
    unread.erase(unread.begin(), unread.begin() + static_cast<std::ptrdiff_t>(bytes));
    const error_code error = bytes == 0 ? error_code(asio::error::eof) : error_code();
    const auto done = std::exchange(read_done_, {});
    done(error, bytes);  // may be the end of this stream
  }

  Relay relay;
  std::optional<StreamId> answer_to;  // of the peer's greeting

 private:
  void put(const asio::const_buffer& buffer) {
    const std::span bytes(static_cast<const std::byte*>(buffer.data()), buffer.size());
    relay.put(federation_->chunk(bytes, is_message_frame(bytes)));
  }
  bool is_there() const {
    if (alive_.expired()) return false;
    const auto found = federation_->streams_.find(peer_);
    return found != federation_->streams_.end() && found->second == this;
  }
  void leave() {
    if (!is_there()) return;
    federation_->counters_.merge(relay.counters(), "federation.");
    federation_->streams_.erase(peer_);
  }

  Federation* const federation_;  // while it is alive
  asio::io_context& io_;
  const std::weak_ptr<bool> alive_;
  const std::string peer_;
  Opened opened_;
  asio::mutable_buffer into_;
  Done read_done_;
};

Federation::Federation(asio::io_context& io, FederationSettings settings)
    : io_(io),
      settings_(std::move(settings)),
      root_(subject_root(settings_.experiment)),
      group_key_(new_secret_key()),
      timer_(io) {
  assert(settings_.keys && "who is in a federation has keys");
  if (!settings_.keys->seals().can_sign())
    throw hal::ConfigError(
        fmt::format("the key of lab {0} is not of the kind Ed25519, so it cannot sign what goes through a NATS server; "
                    "make another: "
                    "arkmesh keys renew {0} --new-key",
                    settings_.lab));
  NatsSettings nats;
  nats.servers = settings_.servers;
  nats.name = fmt::format("arkmesh gateway of {}", settings_.lab);
  nats.server_ca = settings_.options.server_ca;
  nats.credentials = settings_.options.credentials;
  nats.subjects = {fmt::format("{}.*.{}", root_, to_all), fmt::format("{}.*.{}", root_, settings_.lab)};
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

std::unique_ptr<SocketStream> Federation::stream(const std::string& peer) {
  return std::make_unique<Stream>(*this, peer);
}

hal::Counters Federation::counters() const {
  hal::Counters all = counters_;
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
  struct Came {
    PacketView packet;
    bool to_all;
  };
  std::vector<Came> all;
  for (const auto& [subject, bytes] : messages) {
    const auto packet = read_packet(bytes);
    if (!packet) {
      counters_.add("federation.refused.malformed");
      continue;
    }
    if (packet->head.from == settings_.lab) continue;  // our own
    const std::string theirs = fmt::format("{}.{}.", root_, packet->head.from);
    const bool sealed = packet->head.kind == PacketKind::sealed;
    if (subject == theirs + (sealed ? settings_.lab : std::string(to_all)))
      all.push_back({*packet, !sealed});
    else
      counters_.add("federation.refused.subject");
  }
  // Those of two subjects come one subject after the other.
  std::ranges::stable_sort(all, [](const Came& a, const Came& b) {
    return a.packet.head.from == b.packet.head.from && a.packet.head.boot_id == b.packet.head.boot_id &&
           a.packet.head.number < b.packet.head.number;
  });
  for (const Came& each : all) take(each.packet, each.to_all);
}

void Federation::take(const PacketView& packet, bool to_all_labs) {
  const std::string& from = packet.head.from;
  const OtherSeal* const seal = settings_.keys->seals().of(from);
  if (!seal) return refuse("not_trusted", "");
  if (!streams_.contains(from)) return counters_.add("federation.ignored.no_stream");
  std::optional<std::vector<std::byte>> plain;
  auto bytes = packet.body;
  if (!to_all_labs) {
    plain = unseal(seal->shared, packet.body, context(packet.head_bytes, settings_.lab));
    if (!plain) return refuse("seal", from);
    bytes = *plain;
  } else if (packet.head.kind == PacketKind::signed_secret) {
    const auto key = group_keys_.find(from);
    if (key == group_keys_.end() || key->second.boot_id != packet.head.boot_id) return refuse("no_key", from);
    plain = unseal(key->second.key, packet.body, context(packet.head_bytes, to_all));
    if (!plain) return refuse("seal", from);
    bytes = *plain;
  } else if (packet.head.kind == PacketKind::keys) {
    return is_signed(packet, *seal) ? take_keys(packet) : void();
  }
  const auto body = read_body(bytes);
  if (!body) return refuse("malformed", from);
  // What is for others only is not worth a look at its signature.
  if (!is_for_us(from, *body)) return;
  if (!to_all_labs || is_signed(packet, *seal)) take(from, *body);
}

bool Federation::is_for_us(const std::string& from, const PacketBody& body) const {
  const StreamId ours = streams_.at(from)->relay.mine();
  const auto names_us = [&](const auto& each) { return each.yours == ours; };
  return std::ranges::any_of(body.greetings, [&](const Greeting& each) { return each.to == settings_.lab; }) ||
         std::ranges::any_of(body.pieces, names_us) || std::ranges::any_of(body.endings, names_us);
}

bool Federation::is_signed(const PacketView& packet, const OtherSeal& seal) {
  const auto now = microseconds(std::chrono::steady_clock::now());
  Budget& budget = forgeries_.try_emplace(packet.head.from, forgeries_per_s).first->second;
  if (!budget.has(1, now)) {
    refuse("too_many_forged", packet.head.from);
    return false;
  }
  if (seal.has_signed(context(packet.signed_bytes, {}), packet.signature)) return true;
  budget.use(1);
  refuse("signature", packet.head.from);
  return false;
}

void Federation::refuse(const std::string& reason, const std::string& lab) {
  counters_.add(lab.empty() ? "federation.refused." + reason : fmt::format("federation.refused.{}.{}", reason, lab));
  if (!settings_.notice) return;
  if (reason == "signature" || reason == "seal")
    settings_.notice(
        fmt::format("somebody else speaks in the name of lab {} on the NATS server, and is not heard", lab));
}

// Verified, and some of it for us.
void Federation::take(const std::string& from, const PacketBody& body) {
  const auto now = std::chrono::steady_clock::now();
  Stream& stream = *streams_.at(from);
  for (const Greeting& each : body.greetings)
    if (each.to == settings_.lab && stream.relay.hear(each)) {
      stream.answer_to = each.mine;
      keys_sent_ = {};
      flush_soon();
    }
  for (const Piece& each : body.pieces)
    if (each.yours == stream.relay.mine()) stream.relay.take(each, body, now);
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

void Federation::take_keys(const PacketView& packet) {
  const auto keys = read_keys(packet.body);
  if (!keys) return refuse("malformed", packet.head.from);
  const Seals& seals = settings_.keys->seals();
  const OtherSeal& seal = *seals.of(packet.head.from);
  for (const SealedKey& each : *keys) {
    if (!std::ranges::equal(each.reader, std::as_bytes(std::span(seals.pin())).first(each.reader.size()))) continue;
    const auto plain = unseal(seal.shared, each.sealed, context(packet.head_bytes, settings_.lab));
    GroupKey key{.boot_id = packet.head.boot_id};
    if (!plain || plain->size() != key.key.size()) return refuse("seal", packet.head.from);
    std::ranges::copy(*plain, std::as_writable_bytes(std::span(key.key)).begin());
    group_keys_[packet.head.from] = key;
  }
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
  const bool anybody = !streams_.empty();
  if (settings_.options.encrypt && anybody && now - keys_sent_ >= keys_period) send_keys();
  if (now - asked_ >= ask_period) ask();
  for (const auto& [peer, stream] : streams_)
    if (const auto answer = std::exchange(stream->answer_to, {}))
      send_to(*stream, now, {stream->relay.greeting(peer, *answer)});
  send_fresh_messages(now);
  for (const auto& [peer, stream] : streams_)
    if (stream->relay.met() && (stream->relay.next() || stream->relay.owes_answer(now))) send_to(*stream, now);
}

// Who has not been met is asked for.
void Federation::ask() {
  PacketBody body;
  for (const auto& [peer, stream] : streams_)
    if (!stream->relay.met()) body.greetings.push_back(stream->relay.greeting(peer, stream->relay.yours()));
  if (body.greetings.empty()) return;
  asked_ = std::chrono::steady_clock::now();
  publish_to_all(PacketKind::signed_open, encode_body(body));
}

void Federation::send_keys() {
  keys_sent_ = std::chrono::steady_clock::now();
  const PacketHead head{PacketKind::keys, settings_.lab, settings_.boot_id, packets_ + 1};
  std::vector<std::vector<std::byte>> sealed;
  std::vector<SealedKey> keys;
  const auto& others = settings_.keys->seals().others();
  sealed.reserve(others.size());
  for (const auto& [lab, seal] : others) {
    sealed.push_back(
        arkmesh::gateway::seal(seal.shared, std::as_bytes(std::span(group_key_)), context(encode_head(head), lab)));
    SealedKey& each = keys.emplace_back();
    std::ranges::copy(std::as_bytes(std::span(seal.pin)).first(each.reader.size()), each.reader.begin());
    each.sealed = sealed.back();
  }
  publish_to_all(PacketKind::keys, encode_keys(keys));
}

// What several peers get is in the packet once; so is, signed, what one gets: others may watch.
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
      Piece piece = relay.piece(now);
      while (const Chunk* const next = relay.next()) {
        auto known = numbers.find(next);
        if (known == numbers.end()) {
          if (!held.empty() && (bytes + next->bytes.size() > most || held.size() == max_packet_entries)) break;
          known = numbers.emplace(next, static_cast<std::uint16_t>(held.size())).first;
          held.push_back(relay.share_next());
          body.chunks.emplace_back(next->bytes);
          bytes += next->bytes.size() + sizeof(std::uint32_t);
        }
        piece.chunks.push_back(known->second);
        relay.sent(now);
      }
      body.pieces.push_back(std::move(piece));
    }
    publish_to_all(settings_.options.encrypt ? PacketKind::signed_secret : PacketKind::signed_open, encode_body(body));
  }
}

void Federation::send_to(Stream& stream, Time now, std::vector<Greeting> greetings, bool ends) {
  Relay& relay = stream.relay;
  bool more = true;
  for (PacketBody body{.greetings = std::move(greetings)}; more; body = {}) {
    std::vector<ChunkPointer> held;
    std::size_t bytes = 0;
    if (relay.met()) {
      Piece piece = relay.piece(now);
      while (const Chunk* const next = relay.next()) {
        if (!held.empty() && (bytes + next->bytes.size() > room() || held.size() == max_packet_entries)) break;
        piece.chunks.push_back(static_cast<std::uint16_t>(held.size()));
        held.push_back(relay.share_next());
        body.chunks.emplace_back(next->bytes);
        bytes += next->bytes.size() + sizeof(std::uint32_t);
        relay.sent(now);
      }
      body.pieces.push_back(std::move(piece));
    }
    more = relay.met() && relay.next() != nullptr;
    if (ends && !more) body.endings.push_back({relay.yours(), relay.mine()});
    publish_sealed(stream.peer_name(), body);
  }
}

std::size_t Federation::room() const {
  const std::size_t all = std::min(connection_->max_payload(), most_packet_bytes);
  const std::size_t around = packet_overhead_bytes + signature_bytes + seal_bytes;
  return all > around ? all - around : 0;
}

bool Federation::is_congested() const {
  return connection_->waiting_bytes() > most_waiting_bytes;
}

void Federation::publish_to_all(PacketKind kind, std::vector<std::byte> body) {
  std::vector<std::byte> packet = encode_head({kind, settings_.lab, settings_.boot_id, ++packets_});
  if (kind == PacketKind::signed_secret) body = seal(group_key_, body, context(packet, to_all));
  packet.insert(packet.end(), body.begin(), body.end());
  const auto signature = settings_.keys->seals().sign(context(packet, {}));
  packet.insert(packet.end(), signature.begin(), signature.end());
  connection_->publish(fmt::format("{}.{}.{}", root_, settings_.lab, to_all), packet);
}

void Federation::publish_sealed(const std::string& to, const PacketBody& body) {
  const OtherSeal* const other = settings_.keys->seals().of(to);
  if (!other) return;  // revoked since; the session ends at its next check
  std::vector<std::byte> packet = encode_head({PacketKind::sealed, settings_.lab, settings_.boot_id, ++packets_});
  const auto sealed = seal(other->shared, encode_body(body), context(packet, to));
  packet.insert(packet.end(), sealed.begin(), sealed.end());
  connection_->publish(fmt::format("{}.{}.{}", root_, settings_.lab, to), packet);
}

// What is signed, or sealed beside something, together with what it counts for.
std::vector<std::byte> Federation::context(std::span<const std::byte> bytes, std::string_view to) const {
  std::vector<std::byte> out;
  put_text(out, "arkmesh federation 1");
  put_text(out, settings_.experiment);
  put_text(out, to);
  out.insert(out.end(), bytes.begin(), bytes.end());
  return out;
}

void Federation::tick() {
  const auto now = std::chrono::steady_clock::now();
  bool wanted = settings_.options.encrypt && now - keys_sent_ >= keys_period;
  for (const auto& [peer, stream] : streams_) {
    Relay& relay = stream->relay;
    relay.check(now);
    wanted |= relay.met() ? relay.next() || relay.owes_answer(now) : now - asked_ >= ask_period;
  }
  if (wanted) flush_soon();
  timer_.expires_after(tick_period);
  timer_.async_wait([this, alive = std::weak_ptr(alive_)](error_code error) {
    if (!error && !alive.expired()) tick();
  });
}

}  // namespace arkmesh::gateway
