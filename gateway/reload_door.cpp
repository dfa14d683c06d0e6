#include "gateway/reload_door.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/write.hpp>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <optional>
#include <random>
#include <set>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <utility>

#include "hal/config/config.hpp"
#include "hal/counted.hpp"

namespace arkmesh::gateway {
namespace {

namespace asio = boost::asio;
using Local = asio::local::stream_protocol;

constexpr std::size_t max_answer_bytes = 64 << 10;
// Others may bind as many of these names as they like, and take no connection there.
constexpr std::chrono::seconds connects_within{2}, answers_within{5};
using Clock = std::chrono::steady_clock;

// The end of the names of all doors of a file; a name has 107 bytes at most.
std::string end_of_names(const std::filesystem::path& file) {
  const std::string path = std::filesystem::weakly_canonical(file).string();
  return path.substr(path.size() - std::min<std::size_t>(path.size(), 70));
}

constexpr std::string_view begin_of_names = "arkmesh-gateway-";

// Nobody can take it first.
Local::endpoint new_door(const std::filesystem::path& file) {
  std::random_device device;
  return std::string(1, '\0') + fmt::format("{}{:08x}{:08x}{}", begin_of_names, device(), device(), end_of_names(file));
}

// Each once: those that are joined with a door have its name, too.
std::set<Local::endpoint> doors_of(const std::filesystem::path& file) {
  const std::string end = end_of_names(file);
  std::ifstream sockets("/proc/net/unix");
  std::set<Local::endpoint> doors;
  for (std::string line; std::getline(sockets, line);) {
    const auto name = line.find('@' + std::string(begin_of_names));
    if (name == std::string::npos || line.substr(std::min(line.size(), name + 1 + begin_of_names.size() + 16)) != end)
      continue;
    doors.emplace(std::string(1, '\0') + line.substr(name + 1));
  }
  return doors;
}

// By the kernel's word; nothing when it says none.
std::optional<uid_t> user_of(Local::socket& other) {
  ucred who{};
  socklen_t size = sizeof who;
  if (::getsockopt(other.native_handle(), SOL_SOCKET, SO_PEERCRED, &who, &size) != 0) return {};
  return who.uid;
}

}  // namespace

ReloadDoor::ReloadDoor(asio::io_context& io, const std::filesystem::path& file, std::function<std::string()> reload)
    : acceptor_(io, new_door(file)), again_(io), reload_(std::move(reload)) {
  await_request();
}

void ReloadDoor::await_request() {
  acceptor_.async_accept([this](auto error, Local::socket asking) {
    if (error == asio::error::operation_aborted) return;
    if (error) {  // no descriptor is free, say
      again_.expires_after(std::chrono::milliseconds(200));
      return again_.async_wait([this](auto closed) {
        if (!closed) await_request();
      });
    }
    boost::system::error_code gone;
    asking.non_blocking(true, gone);
    if (const auto user = user_of(asking); user == ::geteuid() || user == 0)
      asio::write(asking, asio::buffer(reload_()), gone);
    await_request();
  });
}

std::vector<std::string> reload_gateways(const std::filesystem::path& file) {
  struct stat of_file {};
  const bool is_root = ::geteuid() == 0 && ::stat(file.c_str(), &of_file) == 0;
  const auto is_ours = [&](Local::socket& gateway) {
    const auto user = user_of(gateway);
    return user && (*user == ::geteuid() || *user == 0 || (is_root && *user == of_file.st_uid));
  };
  asio::io_context io;
  std::vector<Local::socket> gateways;
  // A door that is full, its own or one that others made, is tried again beside all others.
  std::set<Local::endpoint> full = doors_of(file);
  for (const auto until = Clock::now() + connects_within; !full.empty() && Clock::now() < until;) {
    std::erase_if(full, [&](const Local::endpoint& door) {
      Local::socket gateway(io, Local());
      gateway.native_non_blocking(true);
      if (::connect(gateway.native_handle(), door.data(), static_cast<socklen_t>(door.size())) != 0)
        return errno != EAGAIN;
      if (is_ours(gateway)) gateways.push_back(std::move(gateway));
      return true;
    });
    if (!full.empty()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::vector<std::string> answers;
  const auto until = Clock::now() + answers_within;
  for (Local::socket& gateway : gateways) {
    std::string& answer = answers.emplace_back(max_answer_bytes, '\0');
    std::size_t bytes = 0;
    for (ssize_t n = 1; n > 0 && bytes < answer.size(); bytes += static_cast<std::size_t>(std::max<ssize_t>(n, 0))) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
      pollfd more{gateway.native_handle(), POLLIN, 0};
      if (::poll(&more, 1, static_cast<int>(std::max<std::int64_t>(left.count(), 0))) <= 0) break;
      n = ::recv(gateway.native_handle(), answer.data() + bytes, answer.size() - bytes, 0);
    }
    answer.resize(bytes);
    if (answer.starts_with('!')) throw hal::ConfigError(answer.substr(1));
    if (answer.empty()) answer = "a gateway has not answered within 5 s; send it SIGHUP to reload its rules\n";
  }
  if (full.empty()) return answers;
  std::string busy = fmt::format(
      "{} of this file's gateways accepted no connection within 2 s; send SIGHUP to those that have not answered",
      hal::counted(full.size(), "socket with the name", "sockets with the name"));
  if (answers.empty()) throw std::runtime_error(busy);
  answers.push_back(busy + "\n");
  return answers;
}

}  // namespace arkmesh::gateway
