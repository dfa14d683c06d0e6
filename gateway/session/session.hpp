// One connection to another gateway over any byte stream, until it is closed: frames in and out, acknowledgements,
// heartbeats, time limits. Does not know which peer it should be talking to: its owner judges the hello.
#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/frame/frame.hpp"
#include "gateway/frame/heartbeat.hpp"
#include "gateway/frame/hello.hpp"
#include "gateway/links/socket_stream.hpp"
#include "gateway/outbox/flow_window.hpp"
#include "gateway/outbox/outbox.hpp"
#include "gateway/session/clock_estimate.hpp"

namespace arkmesh::gateway {

// Time limits of a session. Tests shorten them.
struct SessionTimes {
  using Duration = std::chrono::milliseconds;
  Duration heartbeat{500};  // between two of them
  Duration silence{2'000};  // nothing came for so long: the peer is gone
  Duration stall{10'000};   // it acknowledged nothing for so long: it does not read
  Duration hello{5'000};    // to connect, and to say hello
  Duration answer{700};     // for the first answer of a machine that has answered in an earlier session
  Duration goodbye{1'000};  // for a refused peer to read why
  Duration ack{20};         // what came is acknowledged after so long at the latest
};

class Session : public std::enable_shared_from_this<Session> {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // Why a session ended: a counter name ("session.closed.silent") and words for people.
  struct End {
    std::string counter;
    std::string why;
    bool no_path = false;  // as StreamFailure
  };

  // Who is told. Calls come from the loop, or from check(); never from within send() or close().
  class Owner {
   public:
    // The peer's hello came and is well-formed. Answer with accept() or refuse(), or close().
    virtual void on_hello(Session& session, const Hello& hello) = 0;
    // Both sides accepted each other; messages may flow.
    virtual void on_up(Session& session) = 0;
    virtual void on_message(Session& session, const MessageView& message) = 0;
    // Of a peer that was accepted. `trip`: our last heartbeat and this one, when it answers one.
    virtual void on_heartbeat(Session& session, const Heartbeat& heartbeat, const std::optional<RoundTrip>& trip) = 0;
    // Over; never called after close() or refuse().
    virtual void on_ended(Session& session, const End& end) = 0;

   protected:
    ~Owner() = default;
  };

  // `hello_frame` is the first that is written. Use through a shared_ptr: the loop's pending operations keep the
  // session alive until they have ended.
  // `answer`: within which the other machine's first answer comes; SessionTimes::hello unless less is given.
  Session(std::unique_ptr<SocketStream> stream, const SessionTimes& times, FlowLimits flow,
          std::vector<std::byte> hello_frame, std::optional<SessionTimes::Duration> answer = {});

  // Opens the stream and says hello.
  void begin(Owner& owner);

  // The hello is fine: from now on messages up to `max_message_bytes`, channel included, sending from `outbox`, which
  // outlives the session or its close(). The owner may be another than before.
  void accept(Owner& owner, Outbox& outbox, const Hello& hello, std::size_t max_message_bytes);
  // Only in answer to on_hello(): tells the peer why and ends by itself within the goodbye time.
  void refuse(std::string_view why);
  // Ends at once; says bye when that needs no waiting.
  void close(std::string_view bye);

  // These are exported from now on, in place of those of our hello. False before accept(): what was said stands.
  bool announce(const std::vector<ExportedChannel>& channels);

  // There is something in the outbox. Several calls before the loop turns make one write.
  void flush_soon();
  // Writes it now.
  void flush();
  // To be called about every 50 ms: heartbeats and time limits.
  void check(Time now);

  bool closed() const { return state_ == State::closed; }
  bool up() const { return state_ == State::up; }
  // After accept(), with what the peer announced since.
  const Hello& peer() const { return peer_; }
  // The lab that the other end has proved to be; empty when the connection proves nothing.
  std::string proved_name() const { return stream_->peer_name(); }
  // Written so far: messages, and their bytes without frames and channel name.
  std::uint64_t sent_messages() const { return sent_messages_; }
  std::uint64_t sent_bytes() const { return sent_bytes_; }

 private:
  enum class State { opening, greeting, accepted, up, refused, closed };

  void read();
  void on_bytes(std::span<const std::byte> bytes);
  void on_frame(const FrameDecoder::Frame& frame);
  void on_piece(const FrameDecoder::Frame& frame);
  void on_acknowledged(const Acknowledgement& received);
  void on_heartbeat(const Heartbeat& heartbeat);
  void acknowledge(bool at_once);
  void write();
  void wait_for_release();
  void write_rest();
  void collect_control();
  void on_written(std::size_t bytes);
  void send_control(FrameKind kind, std::span<const std::byte> payload);
  void say_bye(std::string_view why);
  void end(std::string_view counter, std::string why, bool no_path = false);
  void end(const StreamFailure& failure) { end(failure.counter, failure.why, failure.no_path); }
  void shut();

  const std::unique_ptr<SocketStream> stream_;
  const SessionTimes& times_;
  const SessionTimes::Duration answer_;
  Owner* owner_ = nullptr;    // null once nobody is to be told
  Outbox* outbox_ = nullptr;  // from accept() to the end
  State state_ = State::opening;
  Hello peer_;
  std::size_t max_message_bytes_ = 0;
  FrameDecoder decoder_{max_frame_payload_bytes};
  MessageAssembler assembler_;
  std::vector<std::byte> read_buffer_;
  std::vector<std::byte> control_, control_in_write_;   // frames that do not come from the outbox
  bool ack_wanted_ = false, heartbeat_wanted_ = false;  // made when they are written, so that they are never old
  std::vector<boost::asio::const_buffer> in_write_;     // what of it is left
  std::size_t control_left_ = 0;                        // bytes of it before those from the outbox
  bool writing_ = false, flush_posted_ = false, goodbye_written_ = false;
  Time began_, heard_, beat_, state_since_;
  Acknowledgement received_, told_;  // what came; what the peer knows of that
  std::uint64_t delivered_ = 0;      // messages that the peer acknowledged
  FlowWindow window_;
  boost::asio::steady_timer ack_timer_;
  bool ack_timed_ = false;
  boost::asio::steady_timer release_timer_;
  std::optional<Time> release_at_;
  std::optional<std::pair<std::int64_t, Time>> last_heartbeat_;  // its time at the peer, and when it came
  std::uint64_t sent_messages_ = 0, sent_bytes_ = 0;
};

}  // namespace arkmesh::gateway
