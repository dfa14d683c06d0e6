// A federation's stream to a peer: what a session reads and writes there.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <cstddef>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "gateway/federation/federation.hpp"
#include "gateway/frame/frame.hpp"

namespace arkmesh::gateway {

class Federation::Stream final : public SocketStream {
 public:
  Stream(Federation& federation, std::string peer)
      : relay(new_unguessable_number()),
        federation_(&federation),
        io_(federation.io_),
        alive_(federation.alive_),
        peer_(std::move(peer)) {}
  ~Stream() override { leave(); }

  boost::asio::any_io_executor executor() override { return io_.get_executor(); }

  void open(Opened opened) override {
    if (const StreamFailure failure = objection(); !failure.counter.empty()) return opened(failure);
    if (!federation_->connection_->up())
      return opened({"session.failed.server", federation_->connection_->why(), true});
    opened_ = std::move(opened);
    federation_->streams_[peer_] = this;
    federation_->flush_soon();
  }

  void read(boost::asio::mutable_buffer into, Done done) override {
    into_ = into;
    read_done_ = std::move(done);
    if (relay.unread().empty() && !relay.ended()) return;
    boost::asio::post(executor(),
                      [alive = std::weak_ptr(alive_), federation = federation_, peer = peer_, of = relay.mine()] {
                        if (!alive.expired()) federation->deliver(peer, of);
                      });
  }

  void write(std::span<const boost::asio::const_buffer> from, Done done) override {
    const std::size_t bytes = try_write(from);
    boost::asio::post(executor(), [done = std::move(done), bytes] { done({}, bytes); });
  }

  // All of it: how much is under way is the session's to limit.
  std::size_t try_write(std::span<const boost::asio::const_buffer> from) override {
    std::size_t bytes = 0;
    for (const auto& each : from) {
      put(each);
      bytes += each.size();
    }
    federation_->flush_soon();
    return bytes;
  }
  void write_now(boost::asio::const_buffer from) override { put(from); }
  void finish() override {
    if (relay.met() && !relay.ended()) federation_->send_to(*this, std::chrono::steady_clock::now(), {}, true);
  }
  void close() override {
    if (is_there() && relay.met() && !relay.ended())
      federation_->send_to(*this, std::chrono::steady_clock::now(), {}, true);
    leave();
    const auto aborted = make_error_code(boost::asio::error::operation_aborted);
    // Whoever is in the midst of one of these may be all that keeps this stream.
    if (auto opened = std::exchange(opened_, {})) boost::asio::post(executor(), [opened = std::move(opened)] {});
    if (auto done = std::exchange(read_done_, {}))
      boost::asio::post(executor(), [done = std::move(done), aborted] { done(aborted, 0); });
  }

  std::string peer_name() const override { return peer_; }
  StreamFailure objection() const override {
    if (!federation_->keys_.trusts(peer_))
      return {"session.refused.not_trusted", fmt::format("the certificate of lab {0} is not trusted here, or was "
                                                         "revoked; get its file and run: arkmesh keys trust {0}.crt",
                                                         peer_)};
    return {};
  }
  std::string too_slow() const override { return "session.failed.connect"; }
  std::chrono::milliseconds ack_time() const override {
    return is_there() ? federation_->ack_time() : std::chrono::milliseconds(0);
  }

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
    const boost::system::error_code error =
        bytes == 0 ? boost::system::error_code(boost::asio::error::eof) : boost::system::error_code();
    const auto done = std::exchange(read_done_, {});
    done(error, bytes);  // may be the end of this stream
  }

  Relay relay;
  std::set<PacketOrder> seen;         // the newest packets of the peer that counted
  std::optional<StreamId> answer_to;  // of the peer's greeting

 private:
  void put(const boost::asio::const_buffer& buffer) {
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
  boost::asio::io_context& io_;
  const std::weak_ptr<bool> alive_;
  const std::string peer_;
  Opened opened_;
  boost::asio::mutable_buffer into_;
  Done read_done_;
};

}  // namespace arkmesh::gateway
