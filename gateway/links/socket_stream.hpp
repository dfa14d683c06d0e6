// A connection as a session needs it: bytes both ways, whatever carries them. AsioStream makes one of any asio stream:
// a TCP or local socket, an ssl::stream around one. A session that is a template would be compiled for each of them; a
// virtual call is nothing beside the system call that it makes.
// Threading: everything happens on the thread that runs the stream's loop.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <chrono>
#include <functional>
#include <span>
#include <string>
#include <utility>

namespace arkmesh::gateway {

// Why there is no connection, or none any more: a counter name ("session.failed.connect") and words for people. Without
// a counter nothing is wrong.
struct StreamFailure {
  std::string counter;
  std::string why;
  bool no_path = false;  // nobody answered, not even with a refusal: the path is broken, or the machine is off
};

class SocketStream {
 public:
  using Opened = std::function<void(const StreamFailure& failure)>;
  using Done = std::function<void(boost::system::error_code error, std::size_t bytes)>;

  virtual ~SocketStream() = default;
  virtual boost::asio::any_io_executor executor() = 0;
  // Does what it takes before the first byte: connects, shakes hands. May call `opened` before it returns. What is
  // given to open(), read() and write() is kept until it was called and keeps the stream alive.
  virtual void open(Opened opened) = 0;
  // At least one byte, into memory that stays until `done`; at most one at a time.
  virtual void read(boost::asio::mutable_buffer into, Done done) = 0;
  // Some of the bytes, from memory that stays until `done`; at most one at a time.
  virtual void write(std::span<const boost::asio::const_buffer> from, Done done) = 0;
  // How many of the bytes were written without waiting; 0 when the stream cannot tell, or an error is for write() to
  // find. Not during a write().
  virtual std::size_t try_write(std::span<const boost::asio::const_buffer>) { return 0; }
  // As many of the bytes as need no waiting. Not during a write().
  virtual void write_now(boost::asio::const_buffer from) = 0;
  // Nothing more will be written: the peer reads what was written, then the end. Reading goes on.
  virtual void finish() = 0;
  // Ends at once; what is under way is done with an error.
  virtual void close() = 0;

  // Who the other end has proved to be; empty when the stream cannot know. Once it is open.
  virtual std::string peer_name() const { return {}; }
  // What is wrong with talking to the other end any longer. Quick; asked several times a second.
  virtual StreamFailure objection() const { return {}; }
  // What a read() or write() that ended with this error means.
  virtual StreamFailure explain(boost::system::error_code error) const {
    if (error == boost::asio::error::eof) return {"session.closed.by_peer", "connection closed by the peer"};
    return {"session.closed.connection_lost", "connection lost (" + error.message() + ")"};
  }
  // The counter of an open() that takes too long.
  virtual std::string too_slow() const { return "session.failed.connect"; }
  // Acknowledgements of what is little wait for so long, so that several go at once.
  virtual std::chrono::milliseconds ack_time() const { return std::chrono::milliseconds(0); }
  // During open(): what was sent waits for the first answer of the other machine.
  virtual bool awaits_first_answer() const { return false; }
};

// Over a stream that is open already.
template <class Stream>
class AsioStream : public SocketStream {
 public:
  explicit AsioStream(Stream stream) : stream_(std::move(stream)) {}

  boost::asio::any_io_executor executor() override { return stream_.get_executor(); }
  void open(Opened opened) override {
    boost::system::error_code ignored;  // a stream that fails here fails at its first read as well
    stream_.lowest_layer().non_blocking(true, ignored);
    opened({});
  }
  void read(boost::asio::mutable_buffer into, Done done) override { stream_.async_read_some(into, std::move(done)); }
  void write(std::span<const boost::asio::const_buffer> from, Done done) override {
    stream_.async_write_some(from, std::move(done));
  }
  void write_now(boost::asio::const_buffer from) override {
    boost::system::error_code ignored;
    stream_.write_some(from, ignored);
  }
  void finish() override {
    boost::system::error_code ignored;
    stream_.lowest_layer().shutdown(Stream::lowest_layer_type::shutdown_send, ignored);
  }
  void close() override {
    boost::system::error_code ignored;
    stream_.lowest_layer().close(ignored);
  }

 protected:
  Stream stream_;
};

}  // namespace arkmesh::gateway
