// A campaign of faults on an emulated testbed: the same ones with many seeds. Prints for each seed how long it took
// until all robots were where frames say, frames that said something wrong, and messages to robots that nobody had
// named.
//
//   faults_emulated FIRST_SEED SEEDS ROBOTS SECONDS "AT_S COMMAND" ...
//
// Faults are commands of an emulator (`arkmesh emulator --help`), at their seconds since the robots began to walk.
// After the last one the run goes on for SECONDS, or until everybody has been right for 2 s.
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "tests/testbed/observed_testbed.hpp"

using namespace arkmesh;
using namespace arkmesh::tests;

namespace {

struct Fault {
  double at_s;
  std::string command;
};

struct Score {
  double right_after_s = -1;  // the last fault
  int wrong = 0, blind = 0;
  double named_s = 0, off_m = 0;  // until everybody was named; the farthest that a fresh observation was off
};

Score run(std::uint64_t seed, int robots, double seconds, const std::vector<Fault>& faults, bool verbose) {
  ObservedTestbed testbed("", seed, robots);
  const auto before = testbed.emulator().now();
  testbed.start();
  Score score;
  score.named_s = static_cast<double>((testbed.emulator().now() - before).count()) * 1e-6;
  std::size_t next = 0;
  int calm = 0;
  const double last_s = faults.empty() ? 0 : faults.back().at_s;
  for (int n = 1;; ++n) {
    const double now_s = 0.1 * n;
    for (; next < faults.size() && faults[next].at_s <= now_s; ++next) testbed.happen(faults[next].command);
    testbed.step();
    if (testbed.frame)
      for (const auto& seen : testbed.frame->robots)
        if (const auto at = testbed.truth(seen.robot); at && seen.age == hal::LabTime{0})
          score.off_m = std::max(score.off_m, std::hypot(at->x_m - seen.pose.x_m, at->y_m - seen.pose.y_m));
    for (const hal::RobotId id : testbed.arena->info().robots) {
      if (!testbed.wrong(id)) continue;
      ++score.wrong;
      const auto at = testbed.truth(id);
      for (const auto& seen : testbed.frame->robots)
        if (seen.robot == id && verbose)
          fmt::print("  {:.1f} s: robot {} said at {:.3f} {:.3f}, is at {:.3f} {:.3f}\n", now_s, id, seen.pose.x_m,
                     seen.pose.y_m, at ? at->x_m : 9, at ? at->y_m : 9);
    }
    if (next < faults.size()) continue;
    int expected = 0;
    for (const auto& truth : testbed.emulator().truth()) expected += truth.seen.in_arena;
    const int right = testbed.frame ? testbed.right() : 0;
    calm = right >= expected ? calm + 1 : 0;
    if (calm == 1 && score.right_after_s < 0) score.right_after_s = now_s - last_s;
    if (calm == 0) score.right_after_s = -1;
    if (calm >= 20 || now_s > last_s + seconds) break;
  }
  score.blind = testbed.said_blindly();
  if (verbose) {
    for (const hal::RobotId id : testbed.arena->info().robots)
      if (!testbed.right(id)) fmt::print("  robot {} is not right in the end\n", id);
    for (const auto& [name, total] : testbed.arena->counters().all()) fmt::print("  {} = {}\n", name, total);
  }
  return score;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) {
    fmt::print(stderr, "usage: faults_emulated FIRST_SEED SEEDS ROBOTS SECONDS \"AT_S COMMAND\" ...\n");
    return 2;
  }
  std::vector<Fault> faults;
  for (int k = 5; k < argc; ++k) {
    char* end = nullptr;
    const double at_s = std::strtod(argv[k], &end);
    while (*end == ' ') ++end;
    faults.push_back({at_s, end});
  }
  std::ranges::stable_sort(faults, {}, &Fault::at_s);
  const int first = std::atoi(argv[1]), seeds = std::atoi(argv[2]);
  const bool verbose = std::getenv("VERBOSE") != nullptr;
  int late = 0, wrong = 0, blind = 0;
  double longest_s = 0;
  for (int seed = first; seed < first + seeds; ++seed) {
    const Score score = run(static_cast<std::uint64_t>(seed), std::atoi(argv[3]), std::atof(argv[4]), faults, verbose);
    fmt::print(
        "seed {}: named at first {:.1f} s, right after {:.1f} s, wrong frames {}, blind messages {}, at most {:.1f} mm "
        "off\n",
        seed, score.named_s, score.right_after_s, score.wrong, score.blind, 1000 * score.off_m);
    std::fflush(stdout);
    late += score.right_after_s < 0;
    wrong += score.wrong;
    blind += score.blind;
    longest_s = std::max(longest_s, score.right_after_s);
  }
  fmt::print("seeds {}, never right {}, longest {:.1f} s, wrong frames {}, blind messages {}\n", seeds, late, longest_s,
             wrong, blind);
  return wrong > 0 || late > 0;
}
