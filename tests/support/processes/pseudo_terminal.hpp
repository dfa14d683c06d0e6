// A serial port that exists only here: what is written to it comes out of a descriptor. It can be unplugged and plugged
// in again under the same name. libserialport opens it by port() with the help of pty_shim.c only.
#pragma once

#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/processes/process.hpp"

namespace arkmesh::tests {

class PseudoTerminal {
 public:
  PseudoTerminal() { plug(); }
  ~PseudoTerminal() { unplug(); }
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  // Below /dev by name, because libserialport takes nothing else; it finds "/sys/class/tty/../../../tmp/...", a link as
  // it wants one.
  std::string port() const { return "/dev/../../.." + link_.string(); }
  // As anybody else would name it.
  std::string link() const { return link_.string(); }
  void plug() {
    master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0)
      throw std::runtime_error("no pseudo-terminal");
    std::array<char, 64> name{};
    if (::ptsname_r(master_, name.data(), name.size()) != 0)
      throw std::runtime_error("a pseudo-terminal without a name");
    std::filesystem::create_symlink(name.data(), link_);
  }
  void unplug() {
    std::error_code ignored;
    std::filesystem::remove(link_, ignored);
    if (master_ >= 0) ::close(master_);
    master_ = -1;
  }
  // What has been written to the port since the last call, at most `most` bytes.
  std::vector<std::uint8_t> read(std::size_t most = 65'536) {
    std::vector<std::uint8_t> out(most);
    const ssize_t got = ::read(master_, out.data(), out.size());
    out.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    return out;
  }
  // What the device at the port says.
  void say(const std::string& text) { std::ignore = ::write(master_, text.data(), text.size()); }
  termios settings() const {
    termios out{};
    ::tcgetattr(master_, &out);
    return out;
  }

 private:
  TemporaryFolder folder_;
  std::filesystem::path link_ = folder_.path() / "ohc";
  int master_ = -1;
};

}  // namespace arkmesh::tests
