// The peer's hello is judged here for both sides of a connection.
#include "gateway/links/session_link.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "gateway/address.hpp"
#include "gateway/frame/channel_name.hpp"
#include "gateway/links/connections.hpp"
#include "gateway/links/tls_keys.hpp"
#include "hal/arenas/messages.hpp"

namespace arkmesh::gateway {

namespace {

// A link that has been down for long tries rarely: this part of that time passes between two attempts.
constexpr int attempts_per_absence = 8;
constexpr std::chrono::minutes long_absence{2};

// Where a peer was expected.
std::string place(const Target& target) {
  if (const auto* const host = std::get_if<Host>(&target)) return "at " + to_text(*host);
  if (const auto* const endpoint = std::get_if<boost::asio::ip::tcp::endpoint>(&target))
    return "at " + to_text(*endpoint);
  return "in the federation";
}

}  // namespace

SessionLink::SessionLink(Connections& node, std::string peer, std::optional<Target> connect)
    : node_(node), peer_(std::move(peer)), connect_(std::move(connect)), outbox_(node.settings_.outbox_bytes) {
  outbox_.set_longest(node_.settings_.max_message_bytes);
  stats_.why = connect_ ? "not connected yet" : "has not connected yet";
  node_.links_.push_back(this);
}

SessionLink::~SessionLink() {
  stop();
  std::erase(node_.links_, this);
}

void SessionLink::start(Events events) {
  events_ = std::move(events);
  started_ = true;
  alone_since_ = next_attempt_ = std::chrono::steady_clock::now();
  node_.accept();
}

void SessionLink::stop() {
  stopped_ = true;
  events_ = {};
  if (session_) session_->close(fmt::format("the gateway of lab {} stops", node_.settings_.lab));
  forget_session();
  stats_.up = false;
  stats_.why = "stopped";
}

void SessionLink::offer(const Rule& rule, std::string_view, std::span<const std::byte> bytes) {
  if (stopped_) return;
  outbox_.put(rule, bytes, std::chrono::steady_clock::now());
  if (!session_ || !session_->up()) return;
  if (node_.corked_)
    flush_wanted_ = true;
  else
    session_->flush_soon();
}

void SessionLink::flush() {
  if (std::exchange(flush_wanted_, false) && session_ && session_->up()) session_->flush();
}

void SessionLink::keep_only(const Passes& passes) {
  outbox_.keep_only(passes);
}

void SessionLink::announce(const std::vector<ExportedChannel>& exports) {
  if (session_ && !session_->announce(exports)) session_->close("the rules of this gateway have changed");
}

LinkStats SessionLink::stats() const {
  LinkStats stats = stats_;
  if (session_) {
    stats.sent_messages += session_->sent_messages();
    stats.sent_bytes += session_->sent_bytes();
  }
  stats.counters.merge(outbox_.counters());
  stats.counters.merge(inbox_.counters());
  stats.clock = clock_.clock();
  if (stats.clock)
    stats.peer_wall_offset_us =
        stats.clock->offset_us + peer_wall_ahead_us_ - wall_ahead_us(std::chrono::steady_clock::now());
  if (node_.settings_.keys)
    if (const auto days = node_.settings_.keys->days_left(peer_))
      stats.counters.set("certificate.days_left", static_cast<std::uint64_t>(std::max(0L, *days)));
  return stats;
}

void SessionLink::check(Session::Time now) {
  if (stopped_ || !started_) return;
  if (session_) {
    session_->check(now);
    // A refused peer ends without telling.
    if (session_ && session_->closed()) forget_session();
  }
  if (!session_ && connect_ && now >= next_attempt_) connect();
}

void SessionLink::connect() {
  // A machine that has answered before answers again in a few times the time it took, when the path is there. After a
  // long absence the path may have become another, slower one: then only every second attempt is that quick.
  std::optional<SessionTimes::Duration> answer;
  const bool long_gone = std::chrono::steady_clock::now() - alone_since_ > long_absence;
  if (const auto clock = clock_.clock(); clock && !(long_gone && attempts_->number % 2 == 0))
    answer = std::max(node_.settings_.times.answer, SessionTimes::Duration(4 * clock->round_trip_us / 1000));
  ++attempts_->number;
  session_ = node_.make_session(*connect_, peer_, attempts_, answer);
  session_->begin(*this);
}

void SessionLink::forget_session() {
  if (!session_) return;
  stats_.sent_messages += session_->sent_messages();
  stats_.sent_bytes += session_->sent_bytes();
  session_.reset();
  // At once after a session that was up, then rarer and rarer. Half to whole of the pause by chance, so that many peers
  // of a gateway that comes back do not come all at once.
  const auto now = std::chrono::steady_clock::now();
  next_attempt_ = now;
  if (stats_.up) {
    alone_since_ = now;
    return;
  }
  const auto longest = no_path_ ? node_.settings_.path_retry : node_.settings_.longest_retry;
  const auto pause = std::clamp<Session::Time::duration>((now - alone_since_) / attempts_per_absence,
                                                         node_.settings_.first_retry, longest);
  next_attempt_ += std::chrono::duration_cast<Session::Time::duration>(pause * node_.chance_.uniform(0.5, 1.0));
}

bool SessionLink::take(const std::shared_ptr<Session>& session, const Hello& hello) {
  if (session_ && hello.version == protocol_version && hello.boot_id < session_->peer().boot_id) {
    stats_.counters.add("session.refused.older_boot");
    session->refuse(fmt::format("a gateway of lab {} that started later is already connected", peer_));
    return false;
  }
  if (!judge(*session, hello)) return false;
  if (session_) {
    stats_.counters.add("session.replaced");
    if (session_->up() && hello.boot_id != session_->peer().boot_id)
      node_.notice(
          fmt::format("a gateway of lab {} that started later replaced the connected one; if nobody restarted it, "
                      "another program calls itself {}",
                      peer_, peer_));
    session_->close(fmt::format("replaced by a newer connection of lab {}", peer_));
    forget_session();
    change(false, "replaced by a newer connection");
  }
  session_ = session;
  welcome(*session_, hello);
  return true;
}

void SessionLink::welcome(Session& session, const Hello& hello) {
  const std::uint32_t ours = node_.settings_.max_message_bytes;
  outbox_.set_longest(std::min(hello.max_message_bytes, ours));
  session.accept(*this, outbox_, hello, ours + hal::max_channel_name);
}

void SessionLink::on_hello(Session& session, const Hello& hello) {
  if (hello.lab != peer_) {
    const std::string why = fmt::format("{} there is lab {}, not lab {}", place(*connect_), hello.lab, peer_);
    stats_.counters.add("session.refused.lab_name");
    change(false, why);
    return session.refuse(why);
  }
  if (judge(session, hello)) welcome(session, hello);
}

bool SessionLink::judge(Session& session, const Hello& hello) {
  const auto refusal = why_refused(node_.hello_, hello);
  if (!refusal) return true;
  stats_.counters.add(refusal->counter);
  if (!stats_.up) change(false, refusal->sentence);
  session.refuse(refusal->sentence);
  return false;
}

void SessionLink::on_up(Session& session) {
  stats_.peer_version = session.peer().software;
  stats_.counters.add("session.opened");
  const std::uint64_t missing = meet(session.peer());
  change(true, missing == 0
                   ? "connected"
                   : fmt::format("connected; {} ordered messages were lost when its gateway restarted", missing));
}

// What a peer that was started again forgot, and what is to be forgotten of it. Returns how many of its `ordered`
// messages will not come.
std::uint64_t SessionLink::meet(const Hello& hello) {
  const bool anew = hello.boot_id != stats_.peer_boot_id;
  outbox_.send_again(anew);
  if (!anew) return 0;
  stats_.peer_boot_id = hello.boot_id;
  clock_ = {};
  return inbox_.begin();
}

void SessionLink::on_message(Session& session, const MessageView& message) {
  const auto& listed = session.peer().channels;
  if (std::ranges::none_of(listed, [&](const auto& each) { return matches(each.name, message.channel); }))
    return stats_.counters.add("received.refused.unlisted_channel");
  if (!inbox_.take(message.channel, message.sequence)) return;
  ++stats_.received_messages;
  stats_.received_bytes += message.bytes.size();
  if (events_.arrived) events_.arrived(message.channel, message.bytes);
}

void SessionLink::on_heartbeat(Session&, const Heartbeat& heartbeat, const std::optional<RoundTrip>& trip) {
  inbox_.announced(heartbeat.ordered_accepted, heartbeat.ordered_pending);
  peer_wall_ahead_us_ = heartbeat.wall_us;
  if (trip && !clock_.add(*trip)) stats_.counters.add("session.refused.time");
}

void SessionLink::on_ended(Session&, const Session::End& end) {
  stats_.counters.add(end.counter);
  no_path_ = end.no_path;
  forget_session();
  change(false, end.why);
}

void SessionLink::change(bool up, std::string_view why) {
  if (stopped_ || (stats_.up == up && stats_.why == why)) return;
  stats_.up = up;
  stats_.why = why;
  if (const auto tell = events_.changed) tell(up, why);
}

}  // namespace arkmesh::gateway
