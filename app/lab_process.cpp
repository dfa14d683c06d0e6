#include "app/lab_process.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <string>
#include <utility>

#include "hal/arenas/neighbour_detector.hpp"

namespace arkmesh::app {
namespace {

using namespace std::chrono_literals;

constexpr auto neighbours_speak_within = 1200ms;
constexpr auto serve_every = 1ms;  // while the lab computes; a look at the loop costs about a microsecond

lab::Runner::Now since_boot(hal::TimePoint moment) {
  return std::chrono::duration_cast<lab::Runner::Now>(moment.time_since_epoch());
}

}  // namespace

LabProcess::LabProcess(hal::Config config, const std::filesystem::path& directory, bool force, OwnParts* own, bool page)
    : lab_(std::move(config), directory, loop_, own),
      page_(page ? LiveView::make(loop_, {&lab_}, directory.string()) : nullptr),
      public_bus_(lab_.bus_config().url, lab_.bus_config().hear),
      heard_(loop_, public_bus_.descriptor(), [this] { public_bus_.drain(); }),
      traffic_(lab_.bus(), lab_.config().labs) {
  refuse_neighbours();
  lab::claim_run_folder(directory, force);
  lab_.open_run();
  membership_.emplace(lab_, public_bus_);
  if (page_) page_->count();
}

void LabProcess::refuse_neighbours() {
  std::string other;
  const hal::NeighbourDetector detector(public_bus_, [&](const hal::Talker& talker) {
    if (!talker.is_gateway && talker.number != lab_.run_id()) other = talker.lab;
  });
  for (const TimePoint until = time_.now() + neighbours_speak_within; other.empty() && time_.now() < until;) {
    time_.wait_for_anything(std::min(until, time_.now() + 50ms));
    lab_.arena().serve();  // who watches over it sees that the lab lives
  }
  if (!other.empty())
    throw hal::ConfigError(fmt::format(
        "{}: bus.url = \"{}\": another lab process ('{}') is on this LCM port; give each lab a port of its own",
        lab_.file(), public_bus_.url(), other));
}

lab::Runner::Step LabProcess::step() {
  return lab_.runner().step(since_boot(time_.now()));
}

// When the lab wants to go on, if nobody says anything.
hal::TimePoint LabProcess::wanted_at(lab::Runner::Step after) {
  const TimePoint now = time_.now();
  if (after == lab::Runner::Step::advanced || lab_.runner().awaits_scenario()) return now;
  // An arena that nobody asks to go on may still want service: every millisecond then, not without a pause.
  const auto least = lab_.runner().awaits_arena() ? 0ms : 1ms;
  return std::min(std::max(lab_.arena().next_service(), now + least), TimePoint(lab_.runner().due()));
}

void LabProcess::serve_until(TimePoint then) {
  const TimePoint now = time_.now();
  if (then <= now && now - served_ < serve_every) return;
  time_.wait_for_anything(then);
  served_ = time_.now();
}

void LabProcess::run(hal::StopRequest& stop, hal::Progress& progress) {
  lab::Runner& runner = lab_.runner();
  const double period_s = static_cast<double>(lab_.config().period.count()) * 1e-6;
  bool moves = false;
  hal::Outcome outcome = lab::outcome_of(runner);
  for (TimePoint before = time_.now();;) {
    if (stop.stopped()) {
      if (const char* const failure = stop.failure())
        runner.fail(failure);
      else
        runner.stop("stopped by the operator");
    }
    const auto stepped = step();
    if (stepped == lab::Runner::Step::ended) break;
    if (std::exchange(outcome, lab::outcome_of(runner)) != lab::outcome_of(runner)) save_result();
    runner.await_scenario(serve_every);
    const TimePoint then = wanted_at(stepped), between = time_.now();
    serve_until(then);
    const TimePoint after = time_.now();
    if (moves)
      (then > between ? wall_.waiting_s : wall_.computing_s) += std::chrono::duration<double>(after - before).count();
    before = after;
    // From the first period until the last is complete; the lingering for slow peers afterwards is no part of the run.
    moves = runner.period() > 0 && lab::outcome_of(runner) == hal::Outcome::running;
    progress.show(runner.period(), runner.last_period(), period_s, runner.state_text());
  }
  progress.done();
  time_.serve();
  save_result();
  if (page_) page_->finish(time_);
}

void LabProcess::save_result() const {
  lab_.folder().save_result(lab::lab_result(lab_.facts(), lab_.runner(), wall_, traffic_.by_peer()));
}

}  // namespace arkmesh::app
