// How long those wait who show wrong tokens or command without one: each further time twice as long, by address. Right
// tokens never wait, so nobody else at an address can lock its operator out. Single-threaded; time is the caller's.
#pragma once

#include <boost/asio/ip/address.hpp>
#include <chrono>
#include <cstddef>
#include <map>
#include <string>

namespace arkmesh::view {

class Patience {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Wait = std::chrono::milliseconds;
  static constexpr Wait first{50}, longest{5000};
  static constexpr std::chrono::seconds forgets_after{60};
  // Addresses that are told apart; further ones count as one.
  static constexpr std::size_t max_known = 256;

  // Somebody at that address was wrong: how long their answer, or what they say next, is to wait.
  Wait after_wrong(const boost::asio::ip::address& from, Time now);

 private:
  struct Known {
    Wait next = first;
    Time last;
  };
  std::map<std::string, Known> known_;  // by network
};

}  // namespace arkmesh::view
