#include "emulator/pseudo_terminal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
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
        fmt::format("cannot make a pseudo-terminal for the overhead controller: {}", std::strerror(errno)));
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
        fmt::format("emulator.ohc_link = \"{}\" is there and no symbolic link; give another name", there));
  }
  std::filesystem::remove(link_, error);
  std::filesystem::create_symlink(path_, link_, error);
  if (error)
    throw std::runtime_error(
        fmt::format("cannot make the link emulator.ohc_link = \"{}\": {}", std::exchange(link_, {}), error.message()));
}

PseudoTerminal::~PseudoTerminal() {
  std::error_code ignored;
  if (!link_.empty() && std::filesystem::read_symlink(link_, ignored) == path_) std::filesystem::remove(link_, ignored);
}

}  // namespace arkmesh::emulator
