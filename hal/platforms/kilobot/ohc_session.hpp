// One way to an overhead controller, in real time: says something for as long as wanted, puts a program on robots, and
// leaves the controller silent, however it ends.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "cli/status_line.hpp"
#include "hal/counters.hpp"
#include "hal/platforms/kilobot/firmware_upload.hpp"
#include "hal/platforms/kilobot/packet_sender.hpp"

namespace arkmesh::hal::kilobot {

// What one command says: packets, each repeated for so long.
struct OhcSaying {
  std::string name;
  std::vector<hal::kilobot::Packet> packets;
  std::chrono::microseconds each{0};
};

struct OhcUpload {
  std::string name;           // of the program, for people
  std::optional<int> rounds;  // nothing: until the operator stops it
  hal::kilobot::FirmwareUpload::Timing timing;
};

class OhcSession {
 public:
  // `port`: a serial device, or tcp://host:port. `settle`: a controller that begins to live when its line opens hears
  // nothing for so long. Throws CLI::ValidationError when no port can be called that, std::runtime_error when it cannot
  // be opened.
  OhcSession(const std::string& port, std::chrono::microseconds settle);
  ~OhcSession();
  OhcSession(const OhcSession&) = delete;
  OhcSession& operator=(const OhcSession&) = delete;

  // False: the operator stopped it, and was told how far it was. Throws std::runtime_error when the line is lost.
  bool say(const OhcSaying& saying);
  // Shows how far it is; a line that is lost is waited for. False: stopped before a whole round was sent.
  bool upload(hal::kilobot::Firmware firmware, const OhcUpload& wanted);

 private:
  void wait();

  hal::Counters counters_;
  hal::kilobot::SerialLine line_;
  hal::kilobot::PacketSender sender_;
  cli::StatusLine status_;
};

}  // namespace arkmesh::hal::kilobot
