// Reads and writes what fits, never waits. Control frames (hello, heartbeat, bye) go between messages, never into one.
#include "gateway/session.hpp"

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

constexpr std::size_t read_bytes = 64 << 10;
constexpr std::size_t max_messages_per_write = 60, max_bytes_per_write = 256 << 10;
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

Session::Session(std::unique_ptr<ByteStream> stream, const SessionTimes& times, std::vector<std::byte> hello_frame)
    : stream_(std::move(stream)), times_(times), read_buffer_(read_bytes), control_(std::move(hello_frame)) {
  began_ = heard_ = wrote_ = state_since_ = now();
}

void Session::begin(Owner& owner) {
  owner_ = &owner;
  stream_->open([self = shared_from_this()](const StreamFailure& failure) {
    if (self->closed()) return;
    if (!failure.counter.empty()) return self->end(failure);
    self->state_ = State::greeting;
    self->heard_ = self->wrote_ = now();
    self->read();
    self->write();
  });
}

void Session::accept(Owner& owner, Outbox& outbox, const Hello& hello, std::size_t max_payload_bytes) {
  owner_ = &owner;
  outbox_ = &outbox;
  peer_ = hello;
  state_ = State::accepted;
  decoder_.set_max_payload_bytes(max_payload_bytes);
  send_control(FrameKind::heartbeat, {});
}

void Session::refuse(std::string_view why) {
  if (closed()) return;
  assert(!outbox_ && "an accepted peer is closed, not refused");
  owner_ = nullptr;
  state_ = State::refused;
  state_since_ = now();
  send_control(FrameKind::bye, why.substr(0, longest_bye));
}

void Session::close(std::string_view bye) {
  if (closed()) return;
  owner_ = nullptr;
  // In the middle of a message a bye would be taken for its continuation.
  if (state_ != State::opening && state_ != State::refused && !writing_ && !(outbox_ && outbox_->in_message())) {
    const auto frame = encode_frame(FrameKind::bye, std::as_bytes(std::span(bye.substr(0, longest_bye))));
    stream_->write_now(asio::buffer(frame));
  }
  shut();
}

void Session::end(std::string_view counter, std::string why) {
  if (closed()) return;
  shut();
  if (Owner* owner = std::exchange(owner_, nullptr)) owner->on_ended(*this, End{std::string(counter), std::move(why)});
}

void Session::shut() {
  state_ = State::closed;
  if (outbox_) std::exchange(outbox_, nullptr)->rewind();
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
  heard_ = now();
  // A refused peer is only listened to until it has read why.
  while (!closed() && state_ != State::refused) {
    const auto frame = decoder_.next(bytes);
    if (!frame) break;
    on_frame(*frame);
  }
  if (!closed() && decoder_.fault() != FrameDecoder::Fault::none)
    end(fmt::format("session.closed.{}", to_text(decoder_.fault())), decoder_.complaint());
}

void Session::on_frame(const FrameDecoder::Frame& frame) {
  if (frame.kind == FrameKind::bye) {
    return end("session.closed.bye", "the peer says: " + hal::printable(text_of(frame.payload), longest_bye));
  }
  if (state_ == State::greeting) {
    if (frame.kind != FrameKind::hello) return end("session.closed.no_hello", "the peer did not say hello first");
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
  if (frame.kind != FrameKind::message) return;
  const auto message = read_message(frame.payload);
  if (!message) return end("session.closed.bad_message", "a message without channel came");
  owner_->on_message(*this, *message);
}

void Session::flush_soon() {
  if (flush_posted_ || writing_ || closed()) return;
  flush_posted_ = true;
  asio::post(stream_->executor(), [self = shared_from_this()] {
    self->flush_posted_ = false;
    if (!self->closed()) self->write();
  });
}

void Session::send_control(FrameKind kind, std::string_view text) {
  const auto frame = encode_frame(kind, std::as_bytes(std::span(text)));
  control_.insert(control_.end(), frame.begin(), frame.end());
  flush_soon();
}

void Session::write() {
  if (writing_ || closed() || state_ == State::opening) return;
  if (control_written_ == control_in_write_.size()) {
    control_in_write_.clear();
    control_written_ = 0;
    // Not into a message that is partly written.
    if (!outbox_ || !outbox_->in_message()) std::swap(control_, control_in_write_);
  }
  in_write_.clear();
  if (control_written_ < control_in_write_.size())
    in_write_.push_back(asio::buffer(control_in_write_) + control_written_);
  if (state_ == State::up)
    for (const auto part : outbox_->batch(max_messages_per_write, max_bytes_per_write))
      in_write_.push_back(asio::buffer(part.data(), part.size()));
  if (in_write_.empty()) return;

  writing_ = true;
  wrote_ = now();
  stream_->write(in_write_, [self = shared_from_this()](error_code error, std::size_t bytes) {
    self->writing_ = false;
    if (self->closed()) return;
    if (error) return self->end(self->stream_->explain(error));
    self->on_written(bytes);
    self->write();
  });
}

void Session::on_written(std::size_t bytes) {
  wrote_ = now();
  const std::size_t control = std::min(bytes, control_in_write_.size() - control_written_);
  control_written_ += control;
  if (outbox_ && bytes > control) {
    const auto [messages, message_bytes] = outbox_->written(bytes - control);
    sent_messages_ += messages;
    sent_bytes_ += message_bytes - messages * message_overhead_bytes;
  }
  if (state_ == State::refused && !goodbye_written_ && control_.empty() &&
      control_written_ == control_in_write_.size()) {
    goodbye_written_ = true;
    stream_->finish();  // the peer reads the bye, then the end; what it sends meanwhile is read and forgotten
  }
}

void Session::check(Time at) {
  if (closed()) return;
  switch (state_) {
    case State::opening:
      if (at - began_ > times_.hello) end(stream_->too_slow(), "no answer for " + seconds(times_.hello));
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
      if (writing_ && at - wrote_ > times_.stall)
        return end("session.closed.does_not_read", "the peer reads nothing for " + seconds(times_.stall));
      if (!writing_ && at - wrote_ >= times_.heartbeat) send_control(FrameKind::heartbeat, {});
      return;
    case State::closed:
      return;
  }
}

}  // namespace arkmesh::gateway
