// One lab as a process of its own, on its LCM bus; its gateway is another process. Everything is on one event loop: it
// runs for a moment while the lab computes, and sleeps, in one place, while the lab waits for messages, for the arena,
// or for its own next word.
#pragma once

#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <memory>
#include <optional>

#include "app/configured_lab.hpp"
#include "app/live/live_view.hpp"
#include "app/live/traffic_monitor.hpp"
#include "hal/bus/bus.hpp"
#include "hal/config/config.hpp"
#include "hal/on_loop.hpp"
#include "hal/progress.hpp"
#include "hal/stop_request.hpp"
#include "hal/time/loop_time.hpp"
#include "lab/result.hpp"

namespace arkmesh::app {

class LabProcess {
 public:
  // Makes the lab and, with `page`, its page for browsers, joins its LCM bus, and then opens `directory` for its run;
  // what that holds is moved aside with `force`. Throws ConfigError, also when another lab process is on that LCM port
  // or the folder is not empty, and std::runtime_error when there is no such bus. `own` as of ConfiguredLab.
  LabProcess(hal::Config config, const std::filesystem::path& directory, bool force, OwnParts* own = nullptr,
             bool page = false);

  // Runs the lab to its end and writes result.json.
  void run(hal::StopRequest& stop, hal::Progress& progress);
  const ConfiguredLab& lab() const { return lab_; }
  // Null when it has no page.
  const LiveView* page() const { return page_.get(); }

 private:
  using TimePoint = hal::TimePoint;
  void refuse_neighbours();
  lab::Runner::Step step();
  TimePoint wanted_at(lab::Runner::Step after);
  void serve_until(TimePoint then);
  void save_result() const;

  hal::EventLoop loop_;
  hal::LoopTime time_{loop_};
  ConfiguredLab lab_;
  std::unique_ptr<LiveView> page_;
  hal::Bus public_bus_;
  hal::Readable heard_;
  std::optional<ConfiguredLab::Membership> membership_;
  TrafficMonitor traffic_;
  lab::WallTime wall_;
  TimePoint served_{};
};

}  // namespace arkmesh::app
