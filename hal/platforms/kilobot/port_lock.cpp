// The lock is flock's on a file that is named after the port; the file says who has it.
#include "hal/platforms/kilobot/port_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "hal/label.hpp"
#include "hal/platforms/kilobot/descriptor_stream.hpp"
#include "hal/platforms/kilobot/stand_guard.hpp"
#include "hal/wall_time.hpp"

namespace arkmesh::hal::kilobot {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr std::size_t longest_who = 60;
constexpr std::chrono::milliseconds guard_gives_way_within = 1s;

// Where every user may lock: Debian keeps /run/lock for that.
fs::path lock_folder() {
  const fs::path debians = "/run/lock";
  return ::access(debians.c_str(), W_OK) == 0 ? debians : fs::path("/tmp");
}

// A device has several names; the same address in another network namespace is another one.
fs::path lock_file(const std::string& port) {
  std::string name = port;
  std::error_code error;
  if (port.starts_with("tcp://"))
    name += '@' + fs::read_symlink("/proc/self/ns/net", error).string();
  else if (const fs::path device = fs::canonical(port.starts_with('/') ? port : "/dev/" + port, error); !error)
    name = device.string();
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '-';
  return lock_folder() / ("arkmesh-port-" + name.substr(0, 150));
}

struct Holder {
  pid_t process = 0;
  std::string who;
};

// What the file says; anybody may have written it.
Holder holder_in(int file) {
  std::array<char, 128> text{};
  const ssize_t n = ::pread(file, text.data(), text.size(), 0);
  const std::string said(text.data(), static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
  const auto space = said.find(' ');
  Holder out;
  std::from_chars(said.data(), said.data() + said.size(), out.process);
  if (space != std::string::npos) out.who = hal::printable(said.substr(space + 1), longest_who);
  return out;
}

bool is_guard(pid_t process) {
  std::string name;
  std::getline(std::ifstream(fmt::format("/proc/{}/comm", process)), name);
  return process > 1 && name == StandGuard::process_name;
}

// Another user's file can be opened only without O_CREAT (fs.protected_regular).
Handle open_lock(const fs::path& file) {
  Handle out(::open(file.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW));
  if (!out && errno == ENOENT) {
    out = Handle(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666));
    if (out) ::fchmod(out.get(), 0666);
  }
  return out;
}

}  // namespace

PortLock::PortLock(const std::string& port, const std::string& who) {
  const fs::path file = lock_file(port);
  file_ = open_lock(file);
  if (!file_)
    throw PortError(fmt::format("{}: {} cannot be opened, which tells who has the port: {}", port, file.string(),
                                std::strerror(errno)));
  const TimePoint until = machine_time().now() + guard_gives_way_within;
  while (::flock(file_.get(), LOCK_EX | LOCK_NB) != 0) {
    const Holder holder = holder_in(file_.get());
    const bool guarded = is_guard(holder.process) && !who.starts_with(StandGuard::process_name);
    if (!guarded || machine_time().now() >= until || ::kill(holder.process, SIGTERM) != 0)
      throw PortError(
          fmt::format("{} is driven by {} (process {}): only one program can drive an overhead controller, "
                      "so end that one first",
                      port, holder.who.empty() ? "another program" : holder.who, holder.process));
    machine_time().wait_until(machine_time().now() + 10ms);
  }
  const std::string said = fmt::format("{} {}", ::getpid(), hal::printable(who, longest_who));
  if (::ftruncate(file_.get(), 0) != 0 || ::pwrite(file_.get(), said.data(), said.size(), 0) < 0)
    throw PortError(fmt::format("{}: {} cannot be written: {}", port, file.string(), std::strerror(errno)));
}

std::unique_ptr<ByteStream> claim_byte_stream(const std::string& port, const std::string& who) {
  Line line = find_line(port);  // first: a name that is none needs no lock
  line.lock.emplace(port, who);
  return std::make_unique<DescriptorStream>(std::move(line));
}

}  // namespace arkmesh::hal::kilobot
