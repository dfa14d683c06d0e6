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
  // Our end, for the one who reads from it. Once.
  hal::Handle take_master() { return std::move(master_); }

 private:
  hal::Handle master_, slave_;  // the other end is kept open, so that a host may come and go
  std::string path_, link_;
};

}  // namespace arkmesh::emulator
