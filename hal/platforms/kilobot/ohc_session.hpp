// One way to an overhead controller, in real time: says something for as long as wanted, puts a program on robots, and
// leaves the controller silent, however it ends.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/counters.hpp"
#include "hal/platforms/kilobot/firmware_upload.hpp"
#include "hal/platforms/kilobot/packet_sender.hpp"
#include "hal/platforms/kilobot/port_lock.hpp"
#include "hal/progress.hpp"
#include "hal/stop_request.hpp"

namespace arkmesh::hal::kilobot {

// What one command says: packets, each repeated for so long.
struct OhcCommand {
  std::string name;
  std::vector<Packet> packets;
  std::chrono::microseconds each{0};
  bool is_for_robots = true;  // they do something else from then on, so that no guard is needed
};

// How far a command was said: all of it, or it was stopped.
struct OhcSaid {
  bool all = false;
  double seconds = 0, of_seconds = 0;
};

class OhcSession {
 public:
  // `port`: a serial device, or tcp://host:port. `settle`: a controller that begins to live when its line opens hears
  // nothing for so long. `stop` and `progress` outlive the session. Throws PortError when no port can be called that,
  // std::runtime_error when it cannot be opened.
  OhcSession(const std::string& port, std::chrono::microseconds settle, StopRequest& stop, Progress& progress);
  ~OhcSession();
  OhcSession(const OhcSession&) = delete;
  OhcSession& operator=(const OhcSession&) = delete;

  // Throws std::runtime_error when the line is lost.
  OhcSaid say(const OhcCommand& command);
  // Until all rounds are sent or somebody stops it; a line that is lost is waited for.
  void upload(FirmwareUpload& upload);

 private:
  void wait();

  Counters counters_;
  std::shared_ptr<PortLock> lock_;
  PacketPort port_;
  PacketSender sender_;
  StopRequest& stop_;
  Progress& status_;
};

}  // namespace arkmesh::hal::kilobot
