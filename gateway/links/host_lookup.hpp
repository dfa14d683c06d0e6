// Looks up the addresses of a host without making anybody wait: the system's resolver, which blocks for as long as it
// likes, runs in a thread of its own, which nobody waits for either, not even a process that ends.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gateway/address.hpp"

namespace arkmesh::gateway {

class HostLookup {
 public:
  // Without addresses: why, as the end of a sentence.
  using Found = std::function<void(const std::string& error, std::vector<boost::asio::ip::tcp::endpoint> addresses)>;

  // `found` is called once, on the executor, cancelled or not; a number needs no looking up. The executor's context
  // outlives this object, not the thread.
  HostLookup(const boost::asio::any_io_executor& executor, const Host& host, Found found);
  ~HostLookup() { cancel(); }
  HostLookup(const HostLookup&) = delete;
  void cancel();

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;  // with the thread
};

}  // namespace arkmesh::gateway
