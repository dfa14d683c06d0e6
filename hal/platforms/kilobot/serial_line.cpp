// Devices go through libserialport. It opens no pseudo-terminal (socat, arkmesh emulator), because those have no modem
// lines.
#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <libserialport.h>
#include <pwd.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>

#include "hal/platforms/kilobot/descriptor_stream.hpp"
#include "hal/platforms/kilobot/packet.hpp"

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
                 ? fmt::format("there is no serial port {} and no other on this machine; plug the device in", path)
                 : fmt::format("there is no serial port {}; there are: {}", path, ports);
    }
    case EACCES:
    case EPERM:
      return no_permission(path);
    case EBUSY:
    case EWOULDBLOCK:
      return fmt::format(
          "{} is in use by another program, perhaps a lab: only one can drive a controller, so end that one first; "
          "`fuser -v {}` names it",
          path, path);
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

using Port = std::unique_ptr<sp_port, decltype(&sp_free_port)>;

// Libserialport knows devices by the names under /sys/class/tty. Null: none has that name.
Port find_port(const std::string& name) {
  sp_port* found = nullptr;
  return Port(sp_get_port_by_name(name.c_str(), &found) == SP_OK ? found : nullptr, &sp_free_port);
}

// Raw and at the device's speed, although nothing has that speed there.
bool set_terminal(int terminal, int baud) {
  termios line{};
  if (::tcgetattr(terminal, &line) != 0) return false;
  ::cfmakeraw(&line);
  line.c_cflag = (line.c_cflag & ~static_cast<tcflag_t>(CSTOPB | CRTSCTS)) | CLOCAL | CREAD;
  ::cfsetspeed(&line, baud == line_baud ? B38400 : B115200);
  return ::tcsetattr(terminal, TCSANOW, &line) == 0;
}

bool set_port(sp_port* port, int baud) {
  return sp_set_baudrate(port, baud) == SP_OK && sp_set_bits(port, 8) == SP_OK &&
         sp_set_parity(port, SP_PARITY_NONE) == SP_OK && sp_set_stopbits(port, 1) == SP_OK &&
         sp_set_flowcontrol(port, SP_FLOWCONTROL_NONE) == SP_OK;
}

Handle open_device(const std::string& path, int baud) {
  const auto need = [&path](bool good) {
    if (!good) throw PortError(why_not(path, errno));
  };
  errno = first_look(path);
  need(errno == 0);
  std::error_code ignored;
  const std::string device = std::filesystem::canonical(path, ignored).string();
  Port port = find_port(path);
  if (!port) port = find_port(device);
  Handle out;
  if (port) {
    need(sp_open(port.get(), SP_MODE_READ_WRITE) == SP_OK);
    int opened = -1;
    sp_get_port_handle(port.get(), &opened);
    out = Handle(opened);  // sp_free_port() leaves it open
  } else {
    errno = ENOTTY;
    need(device.starts_with("/dev/pts/"));
    out = Handle(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    need(static_cast<bool>(out));
  }
  // For us alone: the lock tells other users of libserialport and kilogui, the ioctl stops everybody but root. On a
  // pseudo-terminal the ioctl would outlast us while the other end is open, so that nobody but root could open it.
  need(::flock(out.get(), LOCK_EX | LOCK_NB) == 0);
  if (port) ::ioctl(out.get(), TIOCEXCL);
  if (!(port ? set_port(port.get(), baud) : set_terminal(out.get(), baud)))
    throw PortError(fmt::format("{} does not support {} baud, 8N1: {}", path, baud, std::strerror(errno)));
  ::tcflush(out.get(), TCIOFLUSH);
  return out;
}

}  // namespace

Line serial_line(const std::string& path, int baud) {
  return {.open = [path, baud] { return open_device(path, baud); },
          .why_lost =
              [path](bool, int code) {
                return path + " was unplugged" + (code == 0 ? "" : fmt::format(" ({})", std::strerror(code)));
              }};
}

}  // namespace arkmesh::hal::kilobot
