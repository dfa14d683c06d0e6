// The newest message of each channel of each lab, with what has come on it: what a viewer that comes late gets first,
// and what the next sample is made of. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/counters.hpp"
#include "view/outbox.hpp"

namespace arkmesh::view {

class Channels {
 public:
  // More channels than labs have, and more bytes; beyond them messages are left out and counted.
  static constexpr std::size_t max_channels = 1000, max_bytes = 64 << 20;

  // Costs a look-up and a copy.
  void note(Kind kind, int lab, std::int64_t t_us, std::string_view name, std::span<const std::byte> data);
  // What has come since the last call, with the slot of its channel in an outbox.
  struct Sample {
    std::size_t slot;
    Parcel parcel;
  };
  std::vector<Sample> take_fresh();
  // The newest of every channel.
  std::vector<Sample> all();

  // Per lab {"channels": {NAME: {"per_s", "bytes_per_s", "count"}}}, of messages since the last call, `seconds` ago.
  nlohmann::json rates(double seconds);
  // From now on is what the next rates() counts.
  void start_rates();
  std::int64_t newest_us() const { return newest_us_; }
  const hal::Counters& counters() const { return counters_; }

 private:
  struct Channel {
    Kind kind;
    std::size_t slot;
    std::int64_t t_us = 0;
    std::vector<std::byte> data;
    bool fresh = false;
    std::uint64_t messages = 0, bytes = 0, messages_before = 0, bytes_before = 0;
    Parcel parcel;  // of `data`, once somebody wanted it
  };
  const Parcel& parcel_of(int lab, const std::string& name, Channel& channel) const;

  std::vector<std::map<std::string, Channel, std::less<>>> labs_;
  std::size_t slots_ = 0, bytes_ = 0;
  std::int64_t newest_us_ = 0;
  hal::Counters counters_;
};

}  // namespace arkmesh::view
