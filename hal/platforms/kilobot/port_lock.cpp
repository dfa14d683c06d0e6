// The lock is flock's on a file that is named after the port. Two bytes of the file have locks of their own, which
// every user may take and see: who waits for a guard to give way, and guards that stand by.
#include "hal/platforms/kilobot/port_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <pwd.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "hal/label.hpp"
#include "hal/platforms/kilobot/descriptor_stream.hpp"
#include "hal/platforms/kilobot/stand_guard.hpp"
#include "hal/time/wall_time.hpp"

namespace arkmesh::hal::kilobot {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr std::size_t longest_who = 60;
constexpr std::chrono::milliseconds guard_gives_way_within = 5s;  // in milliseconds, where the machine has them

constexpr std::chrono::milliseconds guard_says_so_within = 300ms;  // it has the port a moment before the file says so

enum Byte : off_t { wanted_byte = 1000, guard_byte = 1001 };  // beyond what is written

// Where every user may lock: Debian keeps /run/lock for that.
fs::path lock_folder() {
  const fs::path debians = "/run/lock";
  return ::access(debians.c_str(), W_OK) == 0 ? debians : fs::path("/tmp");
}

// The same address in another network namespace is another one.
std::string file_for(const char* what, std::string name) {
  std::error_code error;
  if (name.starts_with("tcp://")) name += '@' + fs::read_symlink("/proc/self/ns/net", error).string();
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '-';
  return lock_folder() / (what + name.substr(0, 150));
}

// A device has several names.
std::string lock_file(const std::string& port) {
  std::error_code error;
  const bool is_device = !port.starts_with("tcp://");
  const fs::path device = is_device ? fs::canonical(port.starts_with('/') ? port : "/dev/" + port, error) : fs::path();
  return file_for("arkmesh-port-", is_device && !error ? device.string() : port);
}

// A name that leads nowhere while its device is away has the same one.
std::string guard_file(const std::string& port) {
  return file_for("arkmesh-guard-", port);
}

PortHolder holder_in(int file) {
  std::array<char, 128> text{};
  const ssize_t n = ::pread(file, text.data(), text.size(), 0);
  const std::string said(text.data(), static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
  PortHolder out;
  std::from_chars(said.data(), said.data() + said.size(), out.process);
  const auto space = std::min(said.find(' '), said.size()), end = std::min(said.find('\n', space), said.size());
  if (space < end) out.who = hal::printable(said.substr(space + 1, end - space - 1), longest_who);
  if (end + 1 < said.size()) out.state = static_cast<PortHolder::State>(said[end + 1]);
  return out;
}

// All of it at once: others read meanwhile. False: errno says why not.
bool write_holder(int file, const PortHolder& holder) {
  std::string said = fmt::format("{} {}\n{}", holder.process, holder.who, static_cast<char>(holder.state));
  said.resize(128, '\n');
  return ::pwrite(file, said.data(), said.size(), 0) >= 0;
}

bool set_byte(int file, Byte byte, short type) {
  struct flock range {};
  range.l_type = type, range.l_whence = SEEK_SET, range.l_start = byte, range.l_len = 1;
  return ::fcntl(file, F_OFD_SETLK, &range) == 0;
}
// Whether somebody else has locked it.
bool is_set(int file, Byte byte) {
  struct flock range {};
  range.l_type = F_WRLCK, range.l_whence = SEEK_SET, range.l_start = byte, range.l_len = 1;
  return ::fcntl(file, F_OFD_GETLK, &range) == 0 && range.l_type != F_UNLCK;
}

std::string user(uid_t id) {
  const passwd* const entry = ::getpwuid(id);
  return entry ? entry->pw_name : fmt::format("{}", id);
}

// The process that has locked the file truly, by what the kernel shows; 0: it does not show it.
pid_t locked_by(int file) {
  struct stat about {};
  if (::fstat(file, &about) != 0) return 0;
  const std::string inode = fmt::format("{:02x}:{:02x}:{} ", major(about.st_dev), minor(about.st_dev), about.st_ino);
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    int process = 0;
    const auto flock = line.find("FLOCK");
    if (flock != std::string::npos && line.find(inode) != std::string::npos &&
        std::sscanf(line.c_str() + flock, "FLOCK %*s %*s %d", &process) == 1)
      return process;
  }
  return 0;
}

// Another user's file can be opened only without O_CREAT (fs.protected_regular).
Handle open_lock(const std::string& port, const std::string& file) {
  Handle out(::open(file.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW));
  if (!out && errno == ENOENT) {
    out = Handle(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666));
    if (out) ::fchmod(out.get(), 0666);
  }
  if (out) return out;
  const int code = errno;
  struct stat about {};
  const std::string whose = ::lstat(file.c_str(), &about) == 0
                                ? fmt::format("; it belongs to user {}, who can remove it", user(about.st_uid))
                                : "";
  throw PortError(fmt::format("{}: {}, which names the user of the port, cannot be opened: {}{}", port, file,
                              std::strerror(code), whose));
}

std::string taken(const std::string& port, int file) {
  const PortHolder holder = holder_in(file);
  const pid_t process = locked_by(file);
  if (holder.state == PortHolder::State::hung)
    return fmt::format(
        "{} is driven by {} (process {}), which hangs; its guard is stopping the robots, and continues once that "
        "process is ended: kill -9 {}",
        port, holder.who, holder.process, holder.process);
  struct stat about {};
  if (process > 0 && process != holder.process && ::stat(fmt::format("/proc/{}", process).c_str(), &about) == 0)
    return fmt::format("{} is locked by process {} of user {}; end that one first", port, process, user(about.st_uid));
  return fmt::format(
      "{} is driven by {} (process {}): only one program can drive an overhead controller, so end that one first", port,
      holder.who.empty() ? "another program" : holder.who, holder.process);
}

}  // namespace

bool PortHolder::is_guard() const {
  return who.starts_with(StandGuard::process_name);
}

std::optional<PortHolder> port_holder(const std::string& port) {
  const Handle file(::open(lock_file(port).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  return file ? std::optional(holder_in(file.get())) : std::nullopt;
}

void note_holder(const std::string& port, pid_t process, PortHolder::State state) {
  const Handle file(::open(lock_file(port).c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW));
  if (!file) return;
  if (const PortHolder holder = holder_in(file.get()); holder.process == process)
    write_holder(file.get(), {process, holder.who, state});
}

Handle stand_by(const std::string& port) {
  try {
    Handle file = open_lock(port, guard_file(port));
    set_byte(file.get(), guard_byte, F_RDLCK);
    return file;
  } catch (const PortError&) {
    return Handle();  // neither can it lock the port
  }
}

PortLock::PortLock(const std::string& port, const std::string& who)
    : port_(port), who_(hal::printable(who, longest_who)), process_(::getpid()) {
  follow();
}

void PortLock::follow() {
  std::string path = lock_file(port_);
  if (path == path_) return;
  Handle before = std::exchange(file_, open_lock(port_, path));
  try {
    lock();
  } catch (const PortError&) {
    file_ = std::move(before);
    throw;
  }
  path_ = std::move(path);
}

void PortLock::lock() {
  const bool guard = who_.starts_with(StandGuard::process_name);
  const TimePoint begun = machine_time().now();
  while (::flock(file_.get(), LOCK_EX | LOCK_NB) != 0) {
    const auto patience = holder_in(file_.get()).is_guard() ? guard_gives_way_within : guard_says_so_within;
    if (guard || machine_time().now() - begun >= patience) throw PortTaken(taken(port_, file_.get()));
    set_byte(file_.get(), wanted_byte, F_WRLCK);
    machine_time().wait_until(machine_time().now() + 5ms);
  }
  if (!guard) write(PortHolder::State::trying);
  set_byte(file_.get(), wanted_byte, F_UNLCK);
}

PortHolder PortLock::former() const {
  return holder_in(file_.get());
}

void PortLock::write(PortHolder::State state) const {
  if (!write_holder(file_.get(), {process_, who_, state}))
    throw PortError(fmt::format("{}: {} cannot be written: {}", port_, path_, std::strerror(errno)));
}

void PortLock::release() const {
  ::flock(file_.get(), LOCK_UN);
}

bool PortLock::is_wanted() const {
  return is_set(file_.get(), wanted_byte);
}

std::string PortLock::guarded_words() const {
  const Handle file(::open(guard_file(port_).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  if (!file || !is_set(file.get(), guard_byte)) return {};
  return fmt::format("; {} of an earlier program keeps stopping the robots once it reaches them",
                     StandGuard::process_name);
}

std::unique_ptr<ByteStream> claim_byte_stream(const std::string& port, const std::string& who,
                                              std::shared_ptr<PortLock>* lock, std::shared_ptr<StandGuard> guard) {
  Line line = find_line(port);  // first: a name that is none needs no lock
  line.lock = std::make_shared<PortLock>(port, who);
  if (guard) guard->keep(line.lock);
  line.guard = std::move(guard);
  if (lock) *lock = line.lock;
  line.open = [open = std::move(line.open), held = line.lock] {
    held->follow();
    return open();
  };
  return std::make_unique<DescriptorStream>(std::move(line));
}

}  // namespace arkmesh::hal::kilobot
