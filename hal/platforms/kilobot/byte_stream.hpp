// The way bytes go to an overhead controller: a serial device of this machine, or a TCP port that leads to one
// (ser2net). One attempt at a connection at a time; trying again is PacketPort's business.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

namespace arkmesh::hal::kilobot {

// A port cannot be used: its name is none, or what it names cannot be opened now; one sentence.
class PortError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Another program has the port: one that tries again later may have it.
class PortTaken : public PortError {
 public:
  using PortError::PortError;
};

class ByteStream {
 public:
  enum class State { closed, opening, open };
  virtual ~ByteStream() = default;
  // Begins to open; no effect unless closed. Never blocks.
  virtual void open() = 0;
  // Where it stands now. Takes what came from the other side out of the way: controllers say nothing. Never blocks.
  virtual State check() = 0;
  // What the last check() took, for records: a robot at the debug header may talk. Valid until the next call of any
  // other function.
  virtual std::span<const std::uint8_t> heard() const { return {}; }
  // Takes as many bytes as fit, none unless open. Never blocks.
  virtual std::size_t write(std::span<const std::uint8_t> bytes) = 0;
  // Bytes taken that have not left this machine's buffers, as far as the system tells.
  virtual std::size_t waiting_bytes() = 0;
  // Ends an open connection so that what its other end has not read is lost there, where the other end does so. False:
  // it is none, and stays.
  virtual bool reset() { return false; }
  // Why it is closed or could not be opened, one sentence; empty while nothing went wrong.
  virtual const std::string& error() const = 0;
};

}  // namespace arkmesh::hal::kilobot
