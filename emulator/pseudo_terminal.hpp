// A pseudo-terminal, which looks like a serial port to the program that opens it.
#pragma once

#include <string>

#include "hal/handle.hpp"

namespace arkmesh::emulator {

// Raw, so that every byte passes. Whoever has it open learns that it is gone when this and the master are closed.
class PseudoTerminal {
 public:
  // `link`, when not empty, becomes a symbolic link to the terminal; an older link there is replaced, anything else is
  // refused. Throws std::runtime_error with one sentence.
  explicit PseudoTerminal(const std::string& link);
  ~PseudoTerminal();
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;
  const std::string& path() const { return path_; }
  // Both ends, for the one who reads from our one and keeps the other one open, so that hosts may come and go. Once.
  hal::Handle take_master() { return std::move(master_); }
  hal::Handle take_slave() { return std::move(slave_); }

 private:
  hal::Handle master_, slave_;
  std::string path_, link_;
};

// Frees a terminal that a host took for itself (TIOCEXCL) and has left. A serial line is free then; on a
// pseudo-terminal it stays so while we keep `slave` open, and nobody but root could open it. Only without `slave` does
// the master tell whether a host is there, so it is opened anew; while a host is there, nothing changes. Quick, for
// every now and then.
void free_if_left(int master, hal::Handle& slave);

}  // namespace arkmesh::emulator
