// Reads and writes what fits, never waits. Control frames (hello, heartbeat, bye) go between messages, never into one.
#include "gateway/tcp_session.hpp"

#include <fmt/format.h>
#include <netinet/tcp.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <cassert>
#include <utility>

#include "gateway/address.hpp"

namespace arkmesh::gateway {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {

constexpr std::size_t read_bytes = 64 << 10;
constexpr std::size_t most_messages_per_write = 60, most_bytes_per_write = 256 << 10;
// Unsent bytes in the kernel: enough to keep it busy, little enough that newer messages can still replace older ones
// here.
constexpr int max_unsent_bytes = 64 << 10;
constexpr std::size_t longest_bye = 255;

TcpSession::Time now() {
  return std::chrono::steady_clock::now();
}

std::string seconds(TcpTimes::Duration duration) {
  return fmt::format("{:g} s", duration.count() / 1000.0);
}

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

TcpSession::TcpSession(Socket socket, const TcpTimes& times, std::vector<std::byte> hello_frame)
    : socket_(std::move(socket)), times_(times), read_buffer_(read_bytes), control_(std::move(hello_frame)) {
  began_ = heard_ = wrote_ = state_since_ = now();
}

void TcpSession::connect(const asio::ip::tcp::endpoint& to, Owner& owner) {
  owner_ = &owner;
  state_ = State::connecting;
  socket_.async_connect(to, [self = shared_from_this(), to](error_code error) {
    if (self->closed()) return;
    if (error) return self->end("session.failed.connect", fmt::format("{}: {}", to_text(to), error.message()));
    self->begin(*self->owner_);
  });
}

void TcpSession::begin(Owner& owner) {
  owner_ = &owner;
  state_ = State::greeting;
  heard_ = wrote_ = now();
  error_code ignored;  // a socket that fails here fails at its first read as well
  socket_.non_blocking(true, ignored);
  socket_.set_option(asio::ip::tcp::no_delay(true), ignored);
  setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &max_unsent_bytes, sizeof max_unsent_bytes);
  read();
  write();
}

void TcpSession::accept(Owner& owner, Outbox& outbox, const Hello& hello, std::size_t max_payload_bytes) {
  owner_ = &owner;
  outbox_ = &outbox;
  peer_ = hello;
  state_ = State::accepted;
  decoder_.set_max_payload_bytes(max_payload_bytes);
  send_control(FrameKind::heartbeat, {});
}

void TcpSession::refuse(std::string_view why) {
  if (closed()) return;
  assert(!outbox_ && "an accepted peer is closed, not refused");
  owner_ = nullptr;
  state_ = State::refused;
  state_since_ = now();
  send_control(FrameKind::bye, why.substr(0, longest_bye));
}

void TcpSession::close(std::string_view bye) {
  if (closed()) return;
  owner_ = nullptr;
  // In the middle of a message a bye would be taken for its continuation.
  if (state_ != State::connecting && state_ != State::refused && !writing_ && !(outbox_ && outbox_->in_message())) {
    const auto frame = encode_frame(FrameKind::bye, std::as_bytes(std::span(bye.substr(0, longest_bye))));
    error_code ignored;
    socket_.write_some(asio::buffer(frame), ignored);
  }
  shut();
}

void TcpSession::end(std::string_view counter, std::string why) {
  if (closed()) return;
  shut();
  if (Owner* owner = std::exchange(owner_, nullptr)) owner->on_ended(*this, End{std::string(counter), std::move(why)});
}

void TcpSession::shut() {
  state_ = State::closed;
  if (outbox_) std::exchange(outbox_, nullptr)->rewind();
  error_code ignored;
  socket_.close(ignored);
}

void TcpSession::read() {
  socket_.async_read_some(asio::buffer(read_buffer_), [self = shared_from_this()](error_code error, std::size_t bytes) {
    if (self->closed()) return;
    if (error == asio::error::eof) return self->end("session.closed.by_peer", "connection closed by the peer");
    if (error) return self->end("session.closed.connection_lost", "connection lost (" + error.message() + ")");
    self->on_bytes(std::span(self->read_buffer_).first(bytes));
    if (!self->closed()) self->read();
  });
}

void TcpSession::on_bytes(std::span<const std::byte> bytes) {
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

void TcpSession::on_frame(const FrameDecoder::Frame& frame) {
  if (frame.kind == FrameKind::bye) {
    std::string why(text_of(frame.payload.first(std::min(frame.payload.size(), longest_bye))));
    for (char& c : why)
      if (c < ' ' || c > '~') c = '?';
    return end("session.closed.bye", "the peer says: " + why);
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

void TcpSession::flush_soon() {
  if (flush_posted_ || writing_ || closed()) return;
  flush_posted_ = true;
  asio::post(socket_.get_executor(), [self = shared_from_this()] {
    self->flush_posted_ = false;
    if (!self->closed()) self->write();
  });
}

void TcpSession::send_control(FrameKind kind, std::string_view text) {
  const auto frame = encode_frame(kind, std::as_bytes(std::span(text)));
  control_.insert(control_.end(), frame.begin(), frame.end());
  flush_soon();
}

void TcpSession::write() {
  if (writing_ || closed() || state_ == State::connecting) return;
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
    for (const auto part : outbox_->batch(most_messages_per_write, most_bytes_per_write))
      in_write_.push_back(asio::buffer(part.data(), part.size()));
  if (in_write_.empty()) return;

  writing_ = true;
  wrote_ = now();
  socket_.async_write_some(
      std::span<const asio::const_buffer>(in_write_), [self = shared_from_this()](error_code error, std::size_t bytes) {
        self->writing_ = false;
        if (self->closed()) return;
        if (error) return self->end("session.closed.connection_lost", "connection lost (" + error.message() + ")");
        self->on_written(bytes);
        self->write();
      });
}

void TcpSession::on_written(std::size_t bytes) {
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
    error_code ignored;  // the peer reads the bye, then the end; what it sends meanwhile is read and forgotten
    socket_.shutdown(Socket::shutdown_send, ignored);
  }
}

void TcpSession::check(Time at) {
  if (closed()) return;
  switch (state_) {
    case State::connecting:
      if (at - began_ > times_.hello) end("session.failed.connect", "no answer for " + seconds(times_.hello));
      return;
    case State::greeting:
      if (at - began_ > times_.hello) end("session.closed.no_hello", "no hello for " + seconds(times_.hello));
      return;
    case State::refused:
      if (at - state_since_ > times_.goodbye) end("", "");
      return;
    case State::accepted:
    case State::up:
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
