#include "gateway/links/host_lookup.hpp"

#include <netdb.h>

#include <atomic>
#include <boost/asio/post.hpp>
#include <cstring>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

namespace arkmesh::gateway {
namespace {

using boost::asio::ip::tcp;

// Threads that wait for the resolver, of the whole process: of a name server that is silent they add up.
constexpr int max_running = 16;
std::atomic<int> running{0};

std::string look_up(const Host& host, std::vector<tcp::endpoint>& addresses) {
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = AI_ADDRCONFIG;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(host.name.c_str(), nullptr, &wanted, &found); error != 0)
    return ::gai_strerror(error);
  for (const addrinfo* each = found; each; each = each->ai_next) {
    tcp::endpoint address;
    if (each->ai_addrlen > address.capacity()) continue;
    std::memcpy(address.data(), each->ai_addr, each->ai_addrlen);
    address.port(host.port);
    addresses.push_back(address);
  }
  ::freeaddrinfo(found);
  return addresses.empty() ? "the name has no address" : "";
}

}  // namespace

struct HostLookup::Shared {
  std::mutex guard;
  Found found;  // guarded; empty once it is on its way to the executor
  boost::asio::any_io_executor executor;

  // Posted under the lock: who has cancelled may destroy the executor's context.
  void tell(std::string error, std::vector<tcp::endpoint> addresses) {
    const std::lock_guard lock(guard);
    if (!found) return;
    boost::asio::post(executor, [found = std::exchange(found, {}), error = std::move(error),
                                 addresses = std::move(addresses)] { found(error, addresses); });
    executor = {};
  }
};

HostLookup::HostLookup(const boost::asio::any_io_executor& executor, const Host& host, Found found)
    : shared_(std::make_shared<Shared>()) {
  shared_->found = std::move(found);
  shared_->executor = executor;
  boost::system::error_code is_name;
  if (const auto address = boost::asio::ip::make_address(host.name, is_name); !is_name) {
    shared_->tell({}, {tcp::endpoint(address, host.port)});
    return;
  }
  if (++running > max_running) {
    --running;
    shared_->tell("the name server does not answer", {});
    return;
  }
  try {
    std::thread([shared = shared_, host] {
      std::vector<tcp::endpoint> addresses;
      std::string error = look_up(host, addresses);
      --running;
      shared->tell(std::move(error), std::move(addresses));
    }).detach();
  } catch (const std::system_error& error) {
    --running;
    shared_->tell(error.what(), {});
  }
}

void HostLookup::cancel() {
  shared_->tell("given up", {});
}

}  // namespace arkmesh::gateway
