#include "app/lab_process.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hal/neighbour_detector.hpp"
#include "hal/wall_time.hpp"

namespace arkmesh::app {

using namespace std::chrono_literals;

LabProcess::LabProcess(hal::Config config, const std::filesystem::path& directory)
    : lab_(std::move(config), directory), public_bus_(lab_.bus_url()), traffic_(lab_.bus()) {
  refuse_neighbours();
  lab_.join(public_bus_);
}

void LabProcess::refuse_neighbours() {
  std::string other;
  hal::NeighbourDetector detector(public_bus_, [&](const hal::Talker& talker) {
    if (!talker.is_gateway && talker.number != lab_.run_id()) other = talker.lab;
  });
  detector.listen(1200ms, [&] { return !other.empty(); });
  if (!other.empty())
    throw hal::ConfigError(fmt::format(
        "{}: bus.url = \"{}\": another lab process ('{}') is on this LCM port; give each lab a port of its own",
        lab_.file(), lab_.bus_url(), other));
}

// Serves the public bus, at most for `time` and not beyond the moment at which the arena wants service.
void LabProcess::serve_bus(std::chrono::milliseconds time) {
  // An arena that nobody asks to go on may still want it: it is served every millisecond then, not without a pause.
  const auto least = lab_.runner().awaits_arena() ? 0ms : std::min(time, 1ms);
  const auto now = Clock::now(), until = std::clamp(lab_.arena().next_service(), now + least, now + time);
  public_bus_.drain(std::chrono::floor<std::chrono::milliseconds>(until - now));
  if (until - now < 1ms) hal::machine_time().wait_until(until);
}

void LabProcess::count(bool waits, Clock::time_point from, Clock::time_point to) {
  (waits ? wall_.waiting_s : wall_.computing_s) += std::chrono::duration<double>(to - from).count();
}

void LabProcess::run(hal::StopRequest& stop, hal::Progress& progress) {
  lab::Runner& runner = lab_.runner();
  const double period_s = static_cast<double>(lab_.config().period.count()) * 1e-6;
  auto before = Clock::now();
  bool moves = false;
  for (;;) {
    if (stop.stopped()) runner.stop("stopped by the operator");
    const auto step = runner.step(std::chrono::duration_cast<lab::Runner::Now>(before.time_since_epoch()));
    if (step == lab::Runner::Step::ended) break;
    const bool waits = step == lab::Runner::Step::waiting;
    const auto between = Clock::now();
    if (moves) count(waits, before, between);
    serve_bus(waits ? 20ms : 0ms);
    before = Clock::now();
    if (moves) count(waits, between, before);
    // From the first period until the last is complete; the lingering for slow peers afterwards is no part of the run.
    moves = runner.period() > 0 && runner.state_text() != "finished";
    progress.show(runner.period(), runner.last_period(), period_s, runner.state_text());
  }
  progress.done();
  public_bus_.drain();
  lab_.folder().save_result(lab::lab_result(runner, wall_, traffic_.by_peer()));
  while (!lab_.arena().end()) {
    serve_bus(20ms);
    lab_.arena().serve();
  }
}

}  // namespace arkmesh::app
