// One connection to another gateway over any byte stream, until it is closed: frames in and out, heartbeats, time
// limits. Does not know which peer it should be talking to: its owner judges the hello.
#pragma once

#include <boost/asio/buffer.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/byte_stream.hpp"
#include "gateway/frame.hpp"
#include "gateway/hello.hpp"
#include "gateway/outbox.hpp"

namespace arkmesh::gateway {

// Time limits of a session. Tests shorten them.
struct SessionTimes {
  using Duration = std::chrono::milliseconds;
  Duration heartbeat{1'000};  // something is sent at least so often
  Duration silence{3'000};    // nothing came for so long: the peer is gone
  Duration stall{10'000};     // it took nothing for so long: it does not read
  Duration hello{5'000};      // to connect, and to say hello
  Duration goodbye{1'000};    // for a refused peer to read why
};

class Session : public std::enable_shared_from_this<Session> {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // Why a session ended: a counter name ("session.closed.silent") and words for people.
  struct End {
    std::string counter;
    std::string why;
  };

  // Who is told. Calls come from the loop, or from check(); never from within send() or close().
  class Owner {
   public:
    // The peer's hello came and is well-formed. Answer with accept() or refuse(), or close().
    virtual void on_hello(Session& session, const Hello& hello) = 0;
    // Both sides accepted each other; messages may flow.
    virtual void on_up(Session& session) = 0;
    virtual void on_message(Session& session, const MessageView& message) = 0;
    // Over; never called after close() or refuse().
    virtual void on_ended(Session& session, const End& end) = 0;

   protected:
    ~Owner() = default;
  };

  // `hello_frame` is the first that is written. Use through a shared_ptr: the loop's pending operations keep the
  // session alive until they have ended.
  Session(std::unique_ptr<ByteStream> stream, const SessionTimes& times, std::vector<std::byte> hello_frame);

  // Opens the stream and says hello.
  void begin(Owner& owner);

  // The hello is fine: from now on frames up to `max_payload_bytes`, sending from `outbox`, which outlives the session
  // or its close(). The owner may be another than before.
  void accept(Owner& owner, Outbox& outbox, const Hello& hello, std::size_t max_payload_bytes);
  // Only in answer to on_hello(): tells the peer why and ends by itself within the goodbye time.
  void refuse(std::string_view why);
  // Ends at once; says bye when that needs no waiting.
  void close(std::string_view bye);

  // There is something in the outbox. Several calls before the loop turns make one write.
  void flush_soon();
  // To be called about every 50 ms: heartbeats and time limits.
  void check(Time now);

  bool closed() const { return state_ == State::closed; }
  bool up() const { return state_ == State::up; }
  // After accept().
  const Hello& peer() const { return peer_; }
  // The lab that the other end has proved to be; empty when the connection proves nothing.
  std::string proved_name() const { return stream_->peer_name(); }
  // Written so far: messages, and their bytes without frame and channel name.
  std::uint64_t sent_messages() const { return sent_messages_; }
  std::uint64_t sent_bytes() const { return sent_bytes_; }

 private:
  enum class State { opening, greeting, accepted, up, refused, closed };

  void read();
  void on_bytes(std::span<const std::byte> bytes);
  void on_frame(const FrameDecoder::Frame& frame);
  void write();
  void on_written(std::size_t bytes);
  void send_control(FrameKind kind, std::string_view text);
  void end(std::string_view counter, std::string why);
  void end(const StreamFailure& failure) { end(failure.counter, failure.why); }
  void shut();

  const std::unique_ptr<ByteStream> stream_;
  const SessionTimes& times_;
  Owner* owner_ = nullptr;    // null once nobody is to be told
  Outbox* outbox_ = nullptr;  // from accept() to the end
  State state_ = State::opening;
  Hello peer_;
  FrameDecoder decoder_{max_hello_bytes};
  std::vector<std::byte> read_buffer_;
  std::vector<std::byte> control_, control_in_write_;  // frames that do not come from the outbox
  std::size_t control_written_ = 0;
  std::vector<boost::asio::const_buffer> in_write_;
  bool writing_ = false, flush_posted_ = false, goodbye_written_ = false;
  Time began_, heard_, wrote_, state_since_;
  std::uint64_t sent_messages_ = 0, sent_bytes_ = 0;
};

}  // namespace arkmesh::gateway
