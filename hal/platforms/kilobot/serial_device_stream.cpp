// Looks the device up by its path each time it opens, so a controller that was plugged in again is found again.
#include "hal/platforms/kilobot/serial_device_stream.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <libserialport.h>
#include <poll.h>
#include <pwd.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "hal/platforms/kilobot/packet.hpp"
#include "hal/platforms/kilobot/terminal_stream.hpp"

namespace arkmesh::hal::kilobot {
namespace {

// "/dev/ttyUSB0 (FT232R USB UART)", ...
std::string ports_there_are() {
  sp_port** ports = nullptr;
  std::string out;
  if (sp_list_ports(&ports) != SP_OK) return out;
  for (sp_port** port = ports; *port; ++port) {
    const char* name = sp_get_port_name(*port);
    const char* description = sp_get_port_description(*port);
    if (!name) continue;
    if (!out.empty()) out += ", ";
    out += description && *description ? fmt::format("{} ({})", name, description) : name;
  }
  sp_free_port_list(ports);
  return out;
}

// The group that may use the device, and who we are, as far as they have names.
std::string no_permission(const std::string& path) {
  struct stat about {};
  std::string group = "dialout", user = "$USER";
  if (::stat(path.c_str(), &about) == 0)
    if (const ::group* entry = ::getgrgid(about.st_gid)) group = entry->gr_name;
  if (const ::passwd* entry = ::getpwuid(::geteuid())) user = entry->pw_name;
  return fmt::format(
      "no permission to open {}: it belongs to group {}; join it with `sudo usermod -aG {} {}` and log in again", path,
      group, group, user);
}

// Why the device cannot be opened, one sentence. `code` is an errno.
std::string why_not(const std::string& path, int code) {
  switch (code) {
    case ENOENT:
    case ENXIO:
    case ENODEV: {
      const std::string ports = ports_there_are();
      return ports.empty()
                 ? fmt::format(
                       "there is no serial port {} and no other on this machine; plug the overhead controller in", path)
                 : fmt::format("there is no serial port {}; there are: {}", path, ports);
    }
    case EACCES:
    case EPERM:
      return no_permission(path);
    case EBUSY:
    case EWOULDBLOCK:
      return why_in_use(path);
    case ENOTTY:
    case EINVAL:
    case EISDIR:
      return fmt::format("{} is not a serial port", path);
    default:
      return fmt::format("{} cannot be opened: {}", path, std::strerror(code));
  }
}

// What opening would say, without the settings of a serial line: libserialport looks into /sys first and tells less.
int first_look(const std::string& path) {
  struct stat about {};
  if (::stat(path.c_str(), &about) != 0) return errno;
  if (!S_ISCHR(about.st_mode)) return ENOTTY;
  return ::faccessat(AT_FDCWD, path.c_str(), R_OK | W_OK, AT_EACCESS) == 0 ? 0 : errno;
}

}  // namespace

void SerialDeviceStream::open() {
  if (port_ || (terminal_ && terminal_->check() != State::closed)) return;
  terminal_.reset();
  if (const int code = first_look(path_)) return lose(why_not(path_, code));
  // libserialport knows devices by the names under /sys/class/tty, so names such as /dev/serial/by-id/... are followed
  // for it
  if (sp_get_port_by_name(path_.c_str(), &port_) != SP_OK) {
    std::error_code ignored;
    const std::string device = std::filesystem::canonical(path_, ignored).string();
    if (sp_get_port_by_name(device.c_str(), &port_) != SP_OK) {
      port_ = nullptr;
      if (!device.starts_with("/dev/pts/")) return lose(why_not(path_, ENOTTY));
      terminal_ = std::make_unique<TerminalStream>(path_);
      return terminal_->open();
    }
  }
  if (sp_open(port_, SP_MODE_READ_WRITE) != SP_OK) {
    const int code = sp_last_error_code();
    sp_free_port(std::exchange(port_, nullptr));
    return lose(why_not(path_, code));
  }

  // for us alone: the lock tells other users of libserialport and kilogui, the ioctl stops everybody but root
  int fd = -1;
  sp_get_port_handle(port_, &fd);
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) return lose(why_not(path_, errno));
  ::ioctl(fd, TIOCEXCL);
  const bool is_set = sp_set_baudrate(port_, line_baud) == SP_OK && sp_set_bits(port_, 8) == SP_OK &&
                      sp_set_parity(port_, SP_PARITY_NONE) == SP_OK && sp_set_stopbits(port_, 1) == SP_OK &&
                      sp_set_flowcontrol(port_, SP_FLOWCONTROL_NONE) == SP_OK;
  if (!is_set) {
    const int code = sp_last_error_code();
    return lose(fmt::format("{} does not take 38400 baud, 8N1: {}", path_, std::strerror(code)));
  }
  sp_flush(port_, SP_BUF_BOTH);
  trouble_.clear();
}

ByteStream::State SerialDeviceStream::check() {
  if (terminal_) return terminal_->check();
  heard_bytes_ = 0;
  if (!port_) return State::closed;
  int fd = -1;
  sp_get_port_handle(port_, &fd);
  pollfd state{fd, POLLIN, 0};
  if (::poll(&state, 1, 0) > 0) {
    if (state.revents & (POLLHUP | POLLERR | POLLNVAL)) {
      lose(fmt::format("{} was unplugged", path_));
      return State::closed;
    }
    const int read = sp_nonblocking_read(port_, heard_.data(), heard_.size());
    if (read < 0 && sp_last_error_code() != EAGAIN) {
      lose(fmt::format("{} was unplugged", path_));
      return State::closed;
    }
    heard_bytes_ = static_cast<std::size_t>(std::max(read, 0));
  }
  return State::open;
}

std::size_t SerialDeviceStream::write(std::span<const std::uint8_t> bytes) {
  if (terminal_) return terminal_->write(bytes);
  if (!port_ || bytes.empty()) return 0;
  const int written = sp_nonblocking_write(port_, bytes.data(), bytes.size());
  if (written >= 0) return static_cast<std::size_t>(written);
  // libserialport 0.1.1 calls a full buffer an error
  const int code = sp_last_error_code();
  if (code == EAGAIN || code == EINTR) return 0;
  lose(fmt::format("{} was unplugged ({})", path_, std::strerror(code)));
  return 0;
}

std::size_t SerialDeviceStream::waiting_bytes() {
  if (terminal_) return terminal_->waiting_bytes();
  if (!port_) return 0;
  const int waiting = sp_output_waiting(port_);
  return waiting > 0 ? static_cast<std::size_t>(waiting) : 0;
}

void SerialDeviceStream::close() {
  if (!port_) return;
  sp_close(port_);
  sp_free_port(port_);
  port_ = nullptr;
}

void SerialDeviceStream::lose(std::string why) {
  close();
  trouble_ = std::move(why);
}

}  // namespace arkmesh::hal::kilobot
