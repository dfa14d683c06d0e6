// How long a whole arena needs until every robot has its name. name_emulated EMULATOR.toml [spelled|ark] [SEED]
// [SECONDS THAT ROBOTS RUN AFTERWARDS] [KEY=VALUE ...]
#include <fmt/format.h>

#include <cstdlib>
#include <string>

#include "tests/support/emulated/naming_trial.hpp"

namespace {

using namespace arkmesh;

int measure(int argc, char** argv) {
  tests::NamingTrial trial{.emulator = argv[1]};
  if (argc > 2) trial.identity = argv[2];
  if (argc > 3) trial.seed = std::strtoull(argv[3], nullptr, 10);
  if (argc > 4) trial.then_s = std::atof(argv[4]);
  for (int i = 5; i < argc; ++i) trial.sets.emplace_back(argv[i]);
  if (trial.identity == "ark") trial.within_s = 400;
  const tests::NamingResult result = tests::name_emulated(trial);
  const auto when = [&](std::size_t n) { return n <= result.named_s.size() && n > 0 ? result.named_s[n - 1] : -1.0; };
  const auto robots = static_cast<std::size_t>(result.robots);
  fmt::print("{} robots, {}, seed {}\n", result.robots, trial.identity, trial.seed);
  fmt::print("  all named after       {:.1f} s (half of them {:.1f} s, all but one {:.1f} s)\n", result.named_all_s,
             when(robots / 2), when(robots - 1));
  fmt::print("  named at the end      {}\n", result.named);
  fmt::print("  wrong names           {} robot-frames\n", result.wrong);
  for (const hal::Pose& pose : result.nameless)
    fmt::print("  nameless              at x {:.4f} m, y {:.4f} m\n", pose.x_m, pose.y_m);
  for (const auto& [name, total] : result.counters.all())
    if (name.starts_with("identity.") || name.starts_with("track.")) fmt::print("  {:<21} {}\n", name, total);
  return result.wrong == 0 && result.named_all_s >= 0 ? 0 : 3;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "name_emulated EMULATOR.toml [spelled|ark] [SEED] [SECONDS AFTERWARDS] [KEY=VALUE ...]\n");
    return 2;
  }
  try {
    return measure(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "name_emulated: {}\n", error.what());
    return 1;
  }
}
