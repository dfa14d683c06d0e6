// The other end of a gateway's connection in a test's own hands: says what the test wants, byte by byte.
#pragma once

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gateway/frame/frame.hpp"
#include "gateway/frame/heartbeat.hpp"
#include "gateway/frame/hello.hpp"

namespace arkmesh::tests {

class RawPeer {
 public:
  // Connects to 127.0.0.1:`port`.
  RawPeer(boost::asio::io_context& io, std::uint16_t port) : socket_(io) {
    socket_.connect({boost::asio::ip::address_v4::loopback(), port});
  }
  // Takes a connection over.
  explicit RawPeer(boost::asio::ip::tcp::socket socket) : socket_(std::move(socket)) {}
  ~RawPeer() { *alive_ = false; }

  // Reads all that comes from now on.
  void listen() {
    socket_.async_read_some(boost::asio::buffer(buffer_), [this, alive = alive_](auto error, std::size_t bytes) {
      if (!*alive) return;
      if (error) {
        closed = true;
        return;
      }
      std::span<const std::byte> rest = std::as_bytes(std::span(buffer_).first(bytes));
      const std::uint64_t before = received.bytes;
      while (const auto frame = decoder_.next(rest)) {
        using gateway::FrameKind;
        if (frame->kind == FrameKind::message || frame->kind == FrameKind::part || frame->kind == FrameKind::last_part)
          take(*frame);
        const std::string payload(reinterpret_cast<const char*>(frame->payload.data()), frame->payload.size());
        if (frame->kind == gateway::FrameKind::bye) bye = payload;
        if (frame->kind == gateway::FrameKind::hello) hello = gateway::read_hello(frame->payload);
        if (frame->kind == gateway::FrameKind::heartbeat) ++heartbeats;
      }
      if (received.bytes > before) say(gateway::FrameKind::ack, gateway::encode(received));
      listen();
    });
  }
  // False when the connection is gone.
  bool say(std::span<const std::byte> bytes) {
    boost::system::error_code error;
    boost::asio::write(socket_, boost::asio::buffer(bytes.data(), bytes.size()), error);
    return !error;
  }
  bool say(std::string_view text) { return say(std::as_bytes(std::span(text))); }
  bool say(gateway::FrameKind kind, std::span<const std::byte> payload = {}) {
    return say(gateway::encode_frame(kind, payload));
  }
  bool beat() { return say(gateway::FrameKind::heartbeat, gateway::encode(gateway::Heartbeat{.received = received})); }
  bool say(const gateway::Hello& hello_of_peer) {
    return say(gateway::FrameKind::hello, gateway::encode_hello(hello_of_peer));
  }

  std::optional<gateway::Hello> hello;
  std::string bye;
  int heartbeats = 0;
  gateway::Acknowledgement received;
  std::vector<std::string> messages;  // channel length, channel, bytes
  bool closed = false;

 private:
  void take(const gateway::FrameDecoder::Frame& frame) {
    received.bytes += gateway::frame_header_bytes + frame.payload.size();
    const auto payload = assembler_.take(frame, 1 << 24);
    if (!payload) return;
    ++received.messages;
    messages.emplace_back(reinterpret_cast<const char*>(payload->data()) + 8, payload->size() - 8);
  }

  boost::asio::ip::tcp::socket socket_;
  std::array<char, 4096> buffer_{};
  gateway::FrameDecoder decoder_{1 << 20};
  gateway::MessageAssembler assembler_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // shared with the pending read
};

}  // namespace arkmesh::tests
