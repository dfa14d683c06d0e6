// One lab as a process of its own, on its LCM bus; its gateway is another process. Waits in one place: for messages,
// and for when the arena wants service.
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <filesystem>

#include "app/configured_lab.hpp"
#include "app/traffic_monitor.hpp"
#include "hal/bus.hpp"
#include "hal/config.hpp"
#include "hal/progress.hpp"
#include "hal/stop_request.hpp"
#include "lab/result.hpp"

namespace arkmesh::app {

class LabProcess {
 public:
  // Makes the lab, which records into `directory`, and joins its LCM bus. Throws ConfigError, also when another lab
  // process is on that LCM port, and std::runtime_error when there is no such bus.
  LabProcess(hal::Config config, const std::filesystem::path& directory);

  // Runs the lab to its end and writes result.json.
  void run(hal::StopRequest& stop, hal::Progress& progress);
  const ConfiguredLab& lab() const { return lab_; }

 private:
  using Clock = std::chrono::steady_clock;
  void refuse_neighbours();
  void serve_bus(std::chrono::milliseconds time);
  void count(bool waits, Clock::time_point from, Clock::time_point to);

  hal::EventLoop loop_;
  ConfiguredLab lab_;
  hal::Bus public_bus_;
  TrafficMonitor traffic_;
  lab::WallTime wall_;
};

}  // namespace arkmesh::app
