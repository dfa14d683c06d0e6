// The two ways to the emulator's overhead controller: a pseudo-terminal, which looks like a serial port, and TCP, as
// ser2net offers one; and TCP for lines of text. Nothing here blocks; all that is held is bounded.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/listening_socket.hpp"

namespace arkmesh::emulator {

using hal::Handle;

// Raw, so that every byte passes. Whoever has it open learns that it is gone when this is destroyed.
class PseudoTerminal {
 public:
  // `link`, when not empty, becomes a symbolic link to the terminal; an older link there is replaced, anything else is
  // refused. Throws std::runtime_error with one sentence.
  explicit PseudoTerminal(const std::string& link);
  ~PseudoTerminal();
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;
  const std::string& path() const { return path_; }
  int handle() const { return master_.get(); }
  // As many bytes as have come, at most `most`.
  std::vector<std::uint8_t> read(std::size_t most);

 private:
  Handle master_, slave_;  // the other end is kept open, so that a host may come and go
  std::string path_, link_;
};

// One client at a time, as a serial port has.
class TcpPort {
 public:
  // Throws std::runtime_error with one sentence; `what` says in it what the port is for.
  TcpPort(const std::string& address, std::uint16_t port, const std::string& what);
  std::uint16_t port() const;
  int listener() const { return listener_.get(); }
  int client() const { return client_.get(); }
  // Takes a client when there is none; sends others away at once.
  void accept();
  std::vector<std::uint8_t> read(std::size_t most);
  void send_away() { client_ = Handle(); }

 private:
  Handle listener_, client_;
};

// Lines of text, each answered with one. Clients that send endless lines or take no answers are sent away.
class LinePort {
 public:
  LinePort(const std::string& address, std::uint16_t port, const std::string& what);
  std::uint16_t port() const;
  void serve(const std::function<std::string(std::string_view)>& answer);

 private:
  struct Client {
    Handle handle;
    std::string in, out;
  };
  static bool serve(Client& client, const std::function<std::string(std::string_view)>& answer);
  Handle listener_;
  std::list<Client> clients_;
};

}  // namespace arkmesh::emulator
