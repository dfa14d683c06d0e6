// Reads and writes what fits, never waits. Control frames (hello, ack, heartbeat, bye) go between batches of messages.
#include "gateway/session/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <cassert>
#include <utility>

#include "hal/label.hpp"

namespace arkmesh::gateway {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {

constexpr std::size_t read_bytes = 128 << 10;
constexpr std::size_t max_frames_per_write = 60, max_bytes_per_write = 128 << 10;
// So much is acknowledged at once, less after SessionTimes::ack.
constexpr std::size_t ack_messages = 32, ack_bytes = 8 << 10;
constexpr std::size_t longest_bye = 255;

Session::Time now() {
  return std::chrono::steady_clock::now();
}

std::string seconds(SessionTimes::Duration duration) {
  return fmt::format("{:g} s", duration.count() / 1000.0);
}

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

Session::Session(std::unique_ptr<SocketStream> stream, const SessionTimes& times, FlowLimits flow,
                 std::vector<std::byte> hello_frame, std::optional<SessionTimes::Duration> answer)
    : stream_(std::move(stream)),
      times_(times),
      answer_(std::min(times.hello, answer.value_or(times.hello))),
      read_buffer_(read_bytes),
      control_(std::move(hello_frame)),
      window_(flow),
      ack_timer_(stream_->executor()),
      release_timer_(stream_->executor()) {
  began_ = heard_ = beat_ = state_since_ = now();
}

void Session::begin(Owner& owner) {
  owner_ = &owner;
  stream_->open([self = shared_from_this()](const StreamFailure& failure) {
    if (self->closed()) return;
    if (!failure.counter.empty()) return self->end(failure);
    self->state_ = State::greeting;
    self->heard_ = now();
    self->read();
    self->write();
  });
}

void Session::accept(Owner& owner, Outbox& outbox, const Hello& hello, std::size_t max_message_bytes) {
  owner_ = &owner;
  outbox_ = &outbox;
  peer_ = hello;
  state_ = State::accepted;
  max_message_bytes_ = max_message_bytes;
  beat_ = now();
  heartbeat_wanted_ = true;
  flush_soon();
}

void Session::refuse(std::string_view why) {
  if (closed()) return;
  assert(!outbox_ && "an accepted peer is closed, not refused");
  owner_ = nullptr;
  state_ = State::refused;
  state_since_ = now();
  send_control(FrameKind::bye, std::as_bytes(std::span(why.substr(0, longest_bye))));
}

void Session::close(std::string_view bye) {
  if (closed()) return;
  owner_ = nullptr;
  if (state_ != State::opening && state_ != State::refused) say_bye(bye);
  shut();
}

// And what the peer should know of its messages and ours, if that needs no waiting.
void Session::say_bye(std::string_view why) {
  if (writing_) return;  // in the middle of a frame it would be taken for its continuation
  control_.clear();
  heartbeat_wanted_ = true;
  collect_control();
  const auto frame = encode_frame(FrameKind::bye, std::as_bytes(std::span(why.substr(0, longest_bye))));
  control_.insert(control_.end(), frame.begin(), frame.end());
  stream_->write_now(asio::buffer(control_));
}

void Session::end(std::string_view counter, std::string why, bool no_path) {
  if (closed()) return;
  shut();
  if (Owner* owner = std::exchange(owner_, nullptr))
    owner->on_ended(*this, End{std::string(counter), std::move(why), no_path});
}

void Session::shut() {
  state_ = State::closed;
  if (outbox_) std::exchange(outbox_, nullptr)->session_lost();
  ack_timer_.cancel();
  release_timer_.cancel();
  stream_->close();
}

void Session::read() {
  stream_->read(asio::buffer(read_buffer_), [self = shared_from_this()](error_code error, std::size_t bytes) {
    if (self->closed()) return;
    if (error) return self->end(self->stream_->explain(error));
    self->on_bytes(std::span(self->read_buffer_).first(bytes));
    if (!self->closed()) self->read();
  });
}

void Session::on_bytes(std::span<const std::byte> bytes) {
  // What waited in the network since then is not worth having: the peer counts it as lost or sends it again.
  if ((state_ == State::accepted || state_ == State::up) && now() - heard_ > times_.silence)
    return end("session.closed.silent", "nothing heard for " + seconds(times_.silence));
  heard_ = now();
  // A refused peer is only listened to until it has read why.
  while (!closed() && state_ != State::refused) {
    const auto frame = decoder_.next(bytes);
    if (!frame) break;
    on_frame(*frame);
  }
  if (!closed() && decoder_.fault() != FrameDecoder::Fault::none) {
    if (state_ == State::up) say_bye(decoder_.error());
    end(fmt::format("session.closed.{}", to_text(decoder_.fault())), decoder_.error());
  }
  if (state_ == State::up) acknowledge(false);
}

void Session::on_frame(const FrameDecoder::Frame& frame) {
  if (frame.kind == FrameKind::bye) {
    return end("session.closed.bye", "the peer says: " + hal::printable(text_of(frame.payload), longest_bye));
  }
  if (state_ != State::up)  // later every few milliseconds (check())
    if (const StreamFailure objection = stream_->objection(); !objection.counter.empty()) return end(objection);
  if (state_ == State::greeting) {
    if (frame.kind != FrameKind::hello) return end("session.closed.no_hello", "the peer did not send a hello first");
    const auto hello = read_hello(frame.payload);
    if (!hello) return end("session.closed.bad_hello", "the peer's hello is malformed");
    return owner_->on_hello(*this, *hello);
  }
  if (frame.kind == FrameKind::hello) return end("session.closed.second_hello", "the peer said hello twice");
  // Anything after the hello means that the peer accepted ours.
  if (state_ == State::accepted) {
    state_ = State::up;
    owner_->on_up(*this);
    flush_soon();
    if (closed() || !owner_) return;
  }
  switch (frame.kind) {
    case FrameKind::message:
    case FrameKind::part:
    case FrameKind::last_part:
      return on_piece(frame);
    case FrameKind::channels:
      if (auto channels = read_channels(frame.payload)) {
        peer_.channels = std::move(*channels);
        return;
      }
      return end("session.closed.bad_channels", "received a malformed list of channels");
    case FrameKind::ack:
      if (const auto received = read_acknowledgement(frame.payload)) return on_acknowledged(*received);
      return end("session.closed.bad_ack", "received a malformed acknowledgement");
    default:
      if (const auto heartbeat = read_heartbeat(frame.payload)) return on_heartbeat(*heartbeat);
      return end("session.closed.bad_heartbeat", "received a malformed heartbeat");
  }
}

void Session::on_piece(const FrameDecoder::Frame& frame) {
  received_.bytes += frame_header_bytes + frame.payload.size();
  const auto payload = assembler_.take(frame, max_message_bytes_ + message_overhead_bytes);
  if (assembler_.overflowed())
    return end("session.closed.bad_length",
               fmt::format("received a message of more than {} bytes", max_message_bytes_));
  if (!payload) return;
  ++received_.messages;
  const auto message = read_message(*payload);
  if (!message) return end("session.closed.bad_message", "received a message without a channel");
  owner_->on_message(*this, *message);
}

void Session::on_acknowledged(const Acknowledgement& received) {
  const bool in_order = received.messages >= delivered_ && window_.acknowledged(received.bytes, now());
  if (!in_order || !outbox_->acknowledged(static_cast<std::size_t>(received.messages - delivered_)))
    return end("session.closed.bad_ack", "the peer acknowledged messages that were never sent");
  delivered_ = received.messages;
  if (outbox_->waiting_messages() > 0) flush_soon();
}

void Session::on_heartbeat(const Heartbeat& heartbeat) {
  const Time at = now();
  last_heartbeat_ = {heartbeat.time_us, at};
  std::optional<RoundTrip> trip;
  if (heartbeat.echo_us > 0)
    trip = RoundTrip{.sent_us = heartbeat.echo_us,
                     .peer_heard_us = heartbeat.time_us - heartbeat.held_us,
                     .peer_sent_us = heartbeat.time_us,
                     .heard_us = monotonic_us(at)};
  if (trip) window_.path_takes(std::chrono::microseconds(trip->heard_us - trip->sent_us - heartbeat.held_us));
  owner_->on_heartbeat(*this, heartbeat, trip);
  if (!closed() && outbox_) on_acknowledged(heartbeat.received);
}

// Tells the peer what came, when that is much; else within SessionTimes::ack.
void Session::acknowledge(bool at_once) {
  const std::uint64_t messages = received_.messages - told_.messages, bytes = received_.bytes - told_.bytes;
  if (bytes == 0 || ack_wanted_) return;
  if (at_once || messages >= ack_messages || bytes >= ack_bytes) {
    ack_wanted_ = true;
    return flush();
  }
  if (std::exchange(ack_timed_, true)) return;
  ack_timer_.expires_after(std::max(times_.ack, stream_->ack_time()));
  ack_timer_.async_wait([self = shared_from_this()](error_code error) {
    self->ack_timed_ = false;
    if (!error && self->state_ == State::up) self->acknowledge(true);
  });
}

void Session::flush_soon() {
  if (flush_posted_ || writing_ || closed()) return;
  flush_posted_ = true;
  asio::post(stream_->executor(), [self = shared_from_this()] {
    self->flush_posted_ = false;
    if (!self->closed()) self->write();
  });
}

void Session::flush() {
  if (!writing_ && !closed()) write();
}

bool Session::announce(const std::vector<ExportedChannel>& channels) {
  if (!outbox_) return false;
  send_control(FrameKind::channels, encode_channels(channels));
  return true;
}

void Session::send_control(FrameKind kind, std::span<const std::byte> payload) {
  const auto frame = encode_frame(kind, payload);
  control_.insert(control_.end(), frame.begin(), frame.end());
  flush_soon();
}

void Session::write() {
  if (writing_ || closed() || state_ == State::opening) return;
  collect_control();
  control_in_write_.clear();
  std::swap(control_, control_in_write_);
  in_write_.clear();
  control_left_ = control_in_write_.size();
  if (control_left_ > 0) in_write_.push_back(asio::buffer(control_in_write_));
  if (state_ == State::up) {
    std::size_t bytes = 0;
    const std::size_t room = std::min(window_.room(now()), max_bytes_per_write);
    for (const auto part : outbox_->batch(max_frames_per_write, room, now())) {
      in_write_.push_back(asio::buffer(part.data(), part.size()));
      bytes += part.size();
    }
    if (bytes > 0) window_.sent(bytes, now());
    wait_for_release();
  }
  if (in_write_.empty()) return;
  if (const std::size_t bytes = stream_->try_write(in_write_); bytes > 0) on_written(bytes);
  if (!in_write_.empty()) return write_rest();
  if (outbox_ && outbox_->waiting_messages() > 0 && window_.room(now()) > 0) flush_soon();
}

// What the outbox holds back goes when its time has come.
void Session::wait_for_release() {
  const std::optional<Time> next = outbox_->next_release();
  if (!next || next == release_at_) return;
  release_at_ = next;
  release_timer_.expires_at(*next);
  release_timer_.async_wait([self = shared_from_this()](error_code error) {
    if (error) return;
    self->release_at_.reset();
    self->flush_soon();
  });
}

void Session::write_rest() {
  writing_ = true;
  stream_->write(in_write_, [self = shared_from_this()](error_code error, std::size_t bytes) {
    self->writing_ = false;
    if (self->closed()) return;
    if (error) return self->end(self->stream_->explain(error));
    self->on_written(bytes);
    if (self->in_write_.empty()) return self->write();
    self->write_rest();
  });
}

// The frames about the session itself that are wanted.
void Session::collect_control() {
  if (!outbox_) return;
  std::vector<std::byte> frame;
  const Time at = now();
  // One that is nearly due goes with messages.
  const bool goes_along =
      state_ == State::up && outbox_->waiting_messages() > 0 && at - beat_ >= times_.heartbeat * 3 / 4;
  if (std::exchange(heartbeat_wanted_, false) || goes_along) {
    beat_ = at;
    Heartbeat heartbeat{.received = received_,
                        .ordered_accepted = outbox_->ordered_accepted(),
                        .ordered_pending = outbox_->ordered_pending(),
                        .time_us = monotonic_us(at),
                        .wall_us = wall_ahead_us(at)};
    if (last_heartbeat_) {
      heartbeat.echo_us = last_heartbeat_->first;
      heartbeat.held_us = monotonic_us(at) - monotonic_us(last_heartbeat_->second);
    }
    frame = encode_frame(FrameKind::heartbeat, encode(heartbeat));
  } else if (ack_wanted_) {
    frame = encode_frame(FrameKind::ack, encode(received_));
  } else {
    return;
  }
  ack_wanted_ = false;
  told_ = received_;
  control_.insert(control_.end(), frame.begin(), frame.end());
}

void Session::on_written(std::size_t bytes) {
  const std::size_t control = std::min(bytes, control_left_);
  control_left_ -= control;
  if (outbox_) {
    const auto [messages, message_bytes] = outbox_->written(bytes - control);
    sent_messages_ += messages;
    sent_bytes_ += message_bytes;
  }
  auto first = in_write_.begin();
  for (; first != in_write_.end() && first->size() <= bytes; ++first) bytes -= first->size();
  if (first != in_write_.end()) *first += bytes;
  in_write_.erase(in_write_.begin(), first);
  if (state_ == State::refused && !goodbye_written_ && control_.empty() && in_write_.empty()) {
    goodbye_written_ = true;
    stream_->finish();  // the peer reads the bye, then the end; what it sends meanwhile is read and forgotten
  }
}

void Session::check(Time at) {
  if (closed()) return;
  switch (state_) {
    case State::opening:
      if (const bool silent = stream_->awaits_first_answer(); at - began_ > (silent ? answer_ : times_.hello))
        end(stream_->too_slow(), "no answer for " + seconds(silent ? answer_ : times_.hello), silent);
      return;
    case State::greeting:
      if (at - began_ > times_.hello) end("session.closed.no_hello", "no hello for " + seconds(times_.hello));
      return;
    case State::refused:
      if (at - state_since_ > times_.goodbye) end("", "");
      return;
    case State::accepted:
    case State::up:
      if (const StreamFailure objection = stream_->objection(); !objection.counter.empty()) return end(objection);
      if (at - heard_ > times_.silence)
        return end("session.closed.silent", "nothing heard for " + seconds(times_.silence));
      window_.peer_waits(stream_->ack_time());  // what holds here holds there
      if (const auto since = window_.waits_since(); since && at - *since > times_.stall)
        return end("session.closed.does_not_read", "the peer reads nothing for " + seconds(times_.stall));
      if (at - beat_ < times_.heartbeat) return;
      heartbeat_wanted_ = true;
      return flush_soon();
    case State::closed:
      return;
  }
}

}  // namespace arkmesh::gateway
