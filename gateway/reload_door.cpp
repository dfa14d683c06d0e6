#include "gateway/reload_door.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <cstddef>
#include <utility>

#include "hal/config.hpp"

namespace arkmesh::gateway {
namespace {

namespace asio = boost::asio;
using Local = asio::local::stream_protocol;

constexpr int max_doors = 8;

std::vector<Local::endpoint> doors_of(const std::filesystem::path& file) {
  const std::string path = std::filesystem::weakly_canonical(file).string();
  std::vector<Local::endpoint> doors;
  for (int i = 0; i < max_doors; ++i)  // a name has 107 bytes at most
    doors.emplace_back(
        std::string(1, '\0') +
        fmt::format("arkmesh-gateway-{}{}", i, path.substr(path.size() - std::min<std::size_t>(path.size(), 80))));
  return doors;
}

// By the kernel's word: of our user, or root's.
bool is_trusted(Local::socket& other) {
  ucred who{};
  socklen_t size = sizeof who;
  return ::getsockopt(other.native_handle(), SOL_SOCKET, SO_PEERCRED, &who, &size) == 0 &&
         (who.uid == ::geteuid() || who.uid == 0 || ::geteuid() == 0);
}

}  // namespace

ReloadDoor::ReloadDoor(asio::io_context& io, const std::filesystem::path& file, std::function<std::string()> reload)
    : acceptor_(io), reload_(std::move(reload)) {
  for (const Local::endpoint& door : doors_of(file)) {
    boost::system::error_code taken;
    acceptor_ = Local::acceptor(io, Local());
    acceptor_.bind(door, taken);
    if (taken) continue;
    acceptor_.listen();
    await_request();
    return;
  }
  acceptor_.close();
}

void ReloadDoor::await_request() {
  acceptor_.async_accept([this](auto error, Local::socket asking) {
    if (error) return;
    boost::system::error_code gone;
    if (is_trusted(asking)) asio::write(asking, asio::buffer(reload_()), gone);
    await_request();
  });
}

std::vector<std::string> reload_gateways(const std::filesystem::path& file) {
  std::vector<std::string> answers;
  for (const Local::endpoint& door : doors_of(file)) {
    asio::io_context io;
    Local::socket gateway(io);
    boost::system::error_code error;
    gateway.connect(door, error);
    if (error || !is_trusted(gateway)) continue;
    asio::read(gateway, asio::dynamic_buffer(answers.emplace_back()), error);
    if (answers.back().starts_with('!')) throw hal::ConfigError(answers.back().substr(1));
  }
  return answers;
}

}  // namespace arkmesh::gateway
