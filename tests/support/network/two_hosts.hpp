// Two hosts of one network: two network namespaces joined by a pair of virtual Ethernet devices. A thread is in one of
// them as long as it holds an Inside; what it opens or starts meanwhile stays there.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "hal/handle.hpp"

namespace arkmesh::tests {

class TwoHosts {
 public:
  // lab_host: 10.9.0.1 on lab0; stranger_host: 10.9.0.2 and 10.9.0.3 on str0. Each sends multicast to its own device.
  // Throws std::runtime_error when this user can have none.
  TwoHosts();
  int lab_host() const { return lab_.get(); }
  int stranger_host() const { return stranger_.get(); }

 private:
  hal::Handle lab_, stranger_;
};

class Inside {
 public:
  explicit Inside(int host);
  ~Inside();
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;

 private:
  hal::Handle before_;
};

// A UDP socket of that host which sends from one of its addresses.
class UdpSender {
 public:
  UdpSender(int host, const std::string& from);
  void send(std::span<const std::byte> datagram, const std::string& to, int port) const;

 private:
  hal::Handle socket_;
};

// Runs a shell command in that host. False when it failed.
bool run_in(int host, const std::string& command);

}  // namespace arkmesh::tests
