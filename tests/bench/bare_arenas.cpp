// The arenas of a recorded run alone: plays what was said to robots into arenas of the same files and seed, without
// gate, bus, recorder and scenario. Prints their processor time, and how many frames were those of the record.
//   bare_arenas RUN SEED FILE...     RUN holds a folder with a log for each file's lab
#include <fmt/format.h>

#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "app/lab_files.hpp"
#include "arkmesh/fleet_command_t.hpp"
#include "arkmesh/pose_frame_t.hpp"
#include "arkmesh/to_robots_t.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/record/event_log.hpp"
#include "sim_ode/ode_arena.hpp"

namespace {

using namespace arkmesh;

// What happens in an arena's run, in order.
struct Event {
  std::optional<hal::PoseFrame> frame;  // the arena goes on to it
  std::vector<hal::ToRobot> words;
  std::optional<hal::FleetCommand> command;
};

std::vector<Event> events_of(const std::filesystem::path& folder) {
  std::vector<Event> out;
  hal::EventLogReader log(hal::log_in(folder));
  while (const auto event = log.next()) {
    pose_frame_t frame;
    to_robots_t words;
    fleet_command_t command;
    if (event->channel == hal::channel::poses && hal::decode(event->bytes, frame))
      out.push_back({.frame = hal::from_message(frame)});
    else if (event->channel == hal::channel::to_robots && hal::decode(event->bytes, words))
      out.push_back({.words = hal::from_message(words)});
    else if (event->channel == hal::channel::fleet_command && hal::decode(event->bytes, command))
      out.push_back({.command = hal::from_message(command)});
  }
  return out;
}

double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 4) {
    fmt::print(stderr, "bare_arenas RUN SEED FILE...\n");
    return 2;
  }
  app::LabFiles files;
  files.files.assign(argv + 3, argv + argc);
  const std::int64_t seed = std::atoll(argv[2]);
  double all_s = 0;
  std::size_t frames = 0, same = 0;
  for (const hal::Config& config : app::read_labs(files, seed)) {
    const auto lab = config.root().section("lab").get("name", std::string());
    const std::vector<Event> events = events_of(std::filesystem::path(argv[1]) / lab);
    const auto arena = sim_ode::make_ode_arena(config.root().section("arena"), lab, static_cast<std::uint64_t>(seed));
    const double before_s = cpu_s();
    for (const Event& event : events) {
      if (event.frame) {
        arena->advance_to(event.frame->stamp);
        const auto seen = arena->poses().latest();
        ++frames;
        same += seen && seen->robots.size() == event.frame->robots.size() &&
                std::equal(seen->robots.begin(), seen->robots.end(), event.frame->robots.begin(),
                           [](const hal::Observation& a, const hal::Observation& b) {
                             return a.pose.x_m == b.pose.x_m && a.pose.y_m == b.pose.y_m && a.led == b.led;
                           });
      } else if (event.command) {
        arena->robots().command(*event.command);
      } else {
        arena->robots().offer(event.words);
      }
    }
    all_s += cpu_s() - before_s;
  }
  fmt::print("arenas cpu_s {:.4f} frames {} same {}\n", all_s, frames, same);
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "bare_arenas: {}\n", error.what());
  return 1;
}
