// A session on streams that are not TCP's; tcp_hello_test and tcp_faults_test have the rest.
#include "gateway/session/session.hpp"

#include <doctest/doctest.h>

#include <boost/asio/local/connect_pair.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/network/tcp_bench.hpp"

namespace arkmesh::gateway {
namespace {

using namespace tests;
using Local = boost::asio::local::stream_protocol::socket;

// Accepts whoever says hello, and remembers what it was told.
struct End final : Session::Owner {
  SessionTimes times = short_times();
  Outbox outbox{4 << 20};
  std::shared_ptr<Session> session;
  Hello peer;
  bool up = false;
  std::vector<std::string> arrived;
  std::vector<Session::End> ends;

  void begin(std::unique_ptr<SocketStream> stream, const std::string& lab) {
    Hello hello;
    hello.lab = lab;
    hello.boot_id = 1;
    hello.max_message_bytes = 1 << 20;
    session = std::make_shared<Session>(std::move(stream), times, FlowLimits{},
                                        encode_frame(FrameKind::hello, encode_hello(hello)));
    session->begin(*this);
  }
  void put(const std::string& channel, std::size_t bytes) {
    outbox.put({std::string(channel), Delivery::ordered}, std::vector<std::byte>(bytes), {});
    session->flush_soon();
  }

  void on_hello(Session& from, const Hello& hello) override {
    peer = hello;
    from.accept(*this, outbox, hello, 1 << 20);
  }
  void on_up(Session&) override { up = true; }
  void on_message(Session&, const MessageView& message) override {
    arrived.push_back(std::string(message.channel) + " " + std::to_string(message.bytes.size()));
  }
  void on_heartbeat(Session&, const Heartbeat&, const std::optional<RoundTrip>&) override {}
  void on_ended(Session&, const Session::End& end) override { ends.push_back(end); }
};

TEST_CASE("a session needs no TCP") {
  // Over a pair of local sockets two sessions greet, carry messages that are longer than a socket takes at once, both
  // ways and in order, and part with a word.
  boost::asio::io_context io;
  Local left_socket(io), right_socket(io);
  boost::asio::local::connect_pair(left_socket, right_socket);
  End left, right;
  left.begin(std::make_unique<AsioStream<Local>>(std::move(left_socket)), "left");
  right.begin(std::make_unique<AsioStream<Local>>(std::move(right_socket)), "right");
  REQUIRE(run_until(io, [&] { return left.up && right.up; }));
  CHECK(left.peer.lab == "right");
  CHECK(right.peer.lab == "left");
  for (const std::size_t bytes : {900'000u, 0u, 1000u}) {
    left.put("world", bytes);
    right.put("events", bytes);
  }
  REQUIRE(run_until(io, [&] { return left.arrived.size() == 3 && right.arrived.size() == 3; }));
  CHECK(right.arrived == std::vector<std::string>{"world 900000", "world 0", "world 1000"});
  CHECK(left.arrived == std::vector<std::string>{"events 900000", "events 0", "events 1000"});
  CHECK(left.session->sent_bytes() == 901'000);

  left.session->close("enough");
  REQUIRE(run_until(io, [&] { return !right.ends.empty(); }));
  CHECK(right.ends[0].why == "the peer says: enough");
  CHECK(left.ends.empty());
}

TEST_CASE("what a rule holds back goes when its time has come") {
  // Three messages at 20 Hz, without any heartbeat that would wake the session.
  boost::asio::io_context io;
  Local left_socket(io), right_socket(io);
  boost::asio::local::connect_pair(left_socket, right_socket);
  End left, right;
  for (End* end : {&left, &right}) end->times.heartbeat = end->times.silence = std::chrono::hours(1);
  left.begin(std::make_unique<AsioStream<Local>>(std::move(left_socket)), "left");
  right.begin(std::make_unique<AsioStream<Local>>(std::move(right_socket)), "right");
  REQUIRE(run_until(io, [&] { return left.up && right.up; }));
  const auto begun = std::chrono::steady_clock::now();
  for (const std::size_t bytes : {1u, 2u, 3u})
    left.outbox.put({.channel = "events", .delivery = Delivery::ordered, .rate_hz = 20}, std::vector<std::byte>(bytes),
                    begun);
  left.session->flush_soon();
  REQUIRE(run_until(io, [&] { return right.arrived.size() == 3; }));
  CHECK(right.arrived == std::vector<std::string>{"events 1", "events 2", "events 3"});
  CHECK(std::chrono::steady_clock::now() - begun >= std::chrono::milliseconds(90));
  for (End* end : {&left, &right}) end->session->close("");
}

// Takes its time to open, and then may not: a handshake that fails.
class Handshake final : public AsioStream<Local> {
 public:
  Handshake(Local socket, std::string error) : AsioStream(std::move(socket)), error_(std::move(error)) {}
  void open(Opened opened) override { opened_ = std::move(opened); }
  void shake() {
    const Opened opened = std::exchange(opened_, nullptr);  // it holds the session, which holds this stream
    if (error_.empty())
      AsioStream::open(opened);
    else
      opened({error_.empty() ? "" : "session.failed.connect", error_});
  }

 private:
  const std::string error_;
  Opened opened_;
};

TEST_CASE("a session waits for its stream to be open") {
  // Nothing is written before, not even the hello; a stream that does not open ends the session with its own words.
  for (const std::string error : {"", "the certificate is somebody else's"}) {
    CAPTURE(error);
    boost::asio::io_context io;
    Local ours(io), theirs(io);
    boost::asio::local::connect_pair(ours, theirs);
    auto stream = std::make_unique<Handshake>(std::move(ours), error);
    Handshake* handshake = stream.get();
    End end;
    end.begin(std::move(stream), "left");
    io.poll();
    CHECK(theirs.available() == 0);
    handshake->shake();
    io.restart();
    io.poll();
    CHECK((theirs.available() > 0) == error.empty());
    REQUIRE(end.ends.size() == (error.empty() ? 0 : 1));
    if (!error.empty()) CHECK(end.ends[0].why == error);
    if (!error.empty()) CHECK(end.ends[0].counter == "session.failed.connect");
    end.session->close("");
  }
}

}  // namespace
}  // namespace arkmesh::gateway
