#include "emulator/pseudo_terminal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace arkmesh::emulator {

PseudoTerminal::PseudoTerminal(const std::string& link)
    : master_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)), link_(link) {
  std::array<char, 256> name{};
  if (!master_ || ::grantpt(master_.get()) != 0 || ::unlockpt(master_.get()) != 0 ||
      ::ptsname_r(master_.get(), name.data(), name.size()) != 0)
    throw std::runtime_error(
        fmt::format("cannot create a pseudo-terminal for the overhead controller: {}", std::strerror(errno)));
  path_ = name.data();
  slave_ = hal::Handle(::open(path_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  termios line{};
  if (!slave_ || ::tcgetattr(slave_.get(), &line) != 0)
    throw std::runtime_error(fmt::format("cannot open the pseudo-terminal {}: {}", path_, std::strerror(errno)));
  ::cfmakeraw(&line);
  ::cfsetspeed(&line, B38400);
  ::tcsetattr(slave_.get(), TCSANOW, &line);
  if (link_.empty()) return;
  std::error_code error;
  const auto status = std::filesystem::symlink_status(link_, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_symlink(status)) {
    const std::string there = std::exchange(link_, {});
    throw std::runtime_error(
        fmt::format("emulator.ohc_link = \"{}\" exists and is not a symbolic link; use another name", there));
  }
  std::filesystem::remove(link_, error);
  std::filesystem::create_symlink(path_, link_, error);
  if (error)
    throw std::runtime_error(fmt::format("cannot create the link emulator.ohc_link = \"{}\": {}",
                                         std::exchange(link_, {}), error.message()));
}

PseudoTerminal::~PseudoTerminal() {
  std::error_code ignored;
  if (!link_.empty() && std::filesystem::read_symlink(link_, ignored) == path_) std::filesystem::remove(link_, ignored);
}

void free_if_left(int master, hal::Handle& slave) {
  int exclusive = 0;
  struct stat as_it_is {};
  if (!slave || ::ioctl(slave.get(), TIOCGEXCL, &exclusive) != 0 || exclusive == 0) return;
  // We could not come back to it otherwise; and meanwhile nobody may open it by its name.
  if (::fstat(slave.get(), &as_it_is) != 0 || ::fchmod(slave.get(), 0) != 0) return;
  ::ioctl(slave.get(), TIOCNXCL);
  slave = hal::Handle();
  pollfd state{master, 0, 0};
  const bool held = ::poll(&state, 1, 0) == 0;
  slave = hal::Handle(::ioctl(master, TIOCGPTPEER, O_RDWR | O_NOCTTY | O_CLOEXEC));
  if (held) ::ioctl(slave.get(), TIOCEXCL);
  ::fchmod(slave.get(), as_it_is.st_mode & 07777);
}

}  // namespace arkmesh::emulator
