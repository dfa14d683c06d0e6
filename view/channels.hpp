// The newest message of each channel of each lab, with what has come on it: what a viewer that comes late gets first,
// and what the next sample is made of. Messages that are parts of one frame count as one: viewers get all or none.
// Pure.
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
#include "view/viewer_outbox.hpp"

namespace arkmesh::view {

// Which message of how many it is that together are one frame.
struct Part {
  std::int32_t frame = 0;  // all parts of a frame have the same number, and no two frames that follow each other
  std::int32_t part = 0, parts = 1;  // 0 <= part < parts
};

class Channels {
 public:
  // More channels than labs have, and more bytes; beyond them messages are left out and counted.
  static constexpr std::size_t max_channels = 1000, max_bytes = 64 << 20;

  // Costs a look-up and a copy. Parts come in their order; a frame of which one is missing is left out and counted.
  void note(Kind kind, int lab, std::int64_t t_us, std::string_view name, std::span<const std::byte> data,
            Part part = {});
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
  // Messages one behind the other, and where each ends.
  struct Messages {
    std::vector<std::byte> data;
    std::vector<std::size_t> ends;
  };
  struct Channel {
    Kind kind;
    std::size_t slot;
    std::int64_t t_us = 0;
    Messages newest, building;  // building: the parts so far of the frame that comes
    std::int32_t frame = 0;     // of the newest part
    bool lacks_part = false;    // that frame does, so nothing more of it is of use
    bool fresh = false;
    std::uint64_t messages = 0, bytes = 0, messages_before = 0, bytes_before = 0;
    Parcel parcel;  // of `newest`, once somebody wanted it
  };
  // Takes a message into `building`; true: that is whole now.
  bool build(Channel& channel, std::span<const std::byte> data, Part part);
  void leave_out(Channel& channel);
  const Parcel& parcel_of(int lab, const std::string& name, Channel& channel) const;

  std::vector<std::map<std::string, Channel, std::less<>>> labs_;
  std::size_t slots_ = 0, bytes_ = 0;
  std::int64_t newest_us_ = 0;
  hal::Counters counters_;
};

}  // namespace arkmesh::view
