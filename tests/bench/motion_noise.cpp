// What the tracker should think of its own errors: what was found in a film of real robots and under an emulated camera
// is followed again and again, until what motion lets expect is likeliest. motion_noise SECONDS [--fit]
// prints how far robots were seen from where they were expected, by the variance that is stated; --fit also the most
// likely value of each constant, and what half and twice that value cost.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <opencv2/core/optim.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "emulator/emulator.hpp"
#include "hal/config/config.hpp"
#include "testbed/kilobot_tracking.hpp"
#include "tests/support/emulated/fitted_cameras.hpp"
#include "tracker/camera/source.hpp"

namespace {

using namespace arkmesh;

constexpr int film_plays = 4;  // times as fast as life

struct Noise {
  tracker::MotionSettings motion = testbed::kilobot_following().motion;
  tracker::LookNoise look;
};
struct Constant {
  const char* name;
  double& (*of)(Noise&);
};
const std::vector<Constant> constants{
    {"centre_px", [](Noise& n) -> double& { return n.look.centre_px; }},
    {"lit.speed", [](Noise& n) -> double& { return n.motion.lit.speed; }},
    {"lit.turn", [](Noise& n) -> double& { return n.motion.lit.turn; }},
    {"lit.slip_m2_s", [](Noise& n) -> double& { return n.motion.lit.slip_m2_s; }},
    {"lit.turned_rad2_s", [](Noise& n) -> double& { return n.motion.lit.turned_rad2_s; }},
    {"touching_lit.slip_m2_s", [](Noise& n) -> double& { return n.motion.touching_lit.slip_m2_s; }},
    {"touching_lit.turned_rad2_s", [](Noise& n) -> double& { return n.motion.touching_lit.turned_rad2_s; }},
    {"dark.speed", [](Noise& n) -> double& { return n.motion.dark.speed; }},
    {"dark.turn", [](Noise& n) -> double& { return n.motion.dark.turn; }},
    {"dark.slip_m2_s", [](Noise& n) -> double& { return n.motion.dark.slip_m2_s; }},
};

// What one camera found, look by look.
struct Found {
  std::string name;
  tracker::ArenaTrackerSettings settings = testbed::kilobot_tracking();
  std::optional<tracker::Calibration> calibration;
  std::vector<std::pair<hal::LabTime, std::vector<tracker::Detection>>> looks;

  void look(tracker::ArenaTracker& tracking, hal::LabTime at, const cv::Mat& picture) {
    tracking.look(at, std::span(&picture, 1));
    if (!tracking.calibration(0)) return;
    calibration = *tracking.calibration(0);
    looks.emplace_back(at, tracking.detections(0));
  }
};

Found in_film(const std::string& file) {
  Found found{.name = "film"};
  tracker::ArenaTracker tracking(found.settings);
  const auto film = tracker::open_recording(file);
  while (const auto picture = film->next()) found.look(tracking, film_plays * picture->stamp, picture->bgr);
  return found;
}

Found under_emulator(const std::string& file, double seconds) {
  const hal::Config config = hal::Config::from_file(file);
  emulator::Emulator emulator(config.root());
  const emulator::Scene& scene = emulator.config().scene;
  Found found{.name = std::filesystem::path(file).stem().string()};
  found.settings.following.half_width_m = scene.width_m / 2,
  found.settings.following.half_height_m = scene.height_m / 2;
  tracker::ArenaTracker tracking(
      {tests::true_calibration(emulator.camera(0).model_at_first(), scene.width_m, scene.height_m)}, found.settings);
  // The overhead controller needs two seconds to start.
  emulator.advance_to(hal::LabTime(3'000'000));
  emulator.command("say run");
  const hal::LabTime end = emulator.now() + hal::LabTime(std::llround(seconds * 1e6));
  cv::Mat picture;
  for (; emulator.now() < end; emulator.advance_to(emulator.now() + emulator.config().frame_period))
    if (emulator.picture(0, picture)) found.look(tracking, emulator.now(), picture);
  return found;
}

struct Followed {
  double seen = 0, leds = 0;  // observations
  tracker::Misfits places, headings;
  double led_noise = 0;
  std::uint64_t jumped = 0;
  // Per observation; what was not believed could be anywhere within reach.
  double nats() const {
    const auto mean = [](const tracker::Misfits& misfits, double of, double anywhere) {
      return of == 0 ? 0 : (misfits.sum.nats + (of - static_cast<double>(misfits.n)) * std::log(anywhere)) / of;
    };
    return mean(places, seen, 0.03) + mean(headings, leds, 6.28);
  }
};

Followed follow(const Found& found, const Noise& noise) {
  tracker::AssociatorSettings settings = found.settings.following;
  settings.motion = noise.motion;
  tracker::Associator associator(settings);
  Followed out;
  for (const auto& [at, detections] : found.looks) {
    const auto seen = tracker::on_arena(*found.calibration, detections, found.settings.body, noise.look);
    out.seen += static_cast<double>(seen.size());
    out.leds += static_cast<double>(
        std::ranges::count_if(seen, [](const auto& one) { return one.led_heading_rad.has_value(); }));
    associator.update(at, seen);
  }
  out.places = associator.places(), out.headings = associator.headings(), out.led_noise = associator.led_noise();
  out.jumped = associator.counters()["track.jumped"];
  return out;
}

class Unlikely : public cv::MinProblemSolver::Function {
 public:
  explicit Unlikely(const std::vector<Found>& all) : all_(all) {}
  int getDims() const override { return static_cast<int>(constants.size()); }
  double calc(const double* logarithms) const override {
    Noise noise;
    for (std::size_t i = 0; i < constants.size(); ++i) constants[i].of(noise) = std::exp(logarithms[i]);
    noise.motion.touching_lit.speed = noise.motion.lit.speed, noise.motion.touching_lit.turn = noise.motion.lit.turn;
    return of(noise);
  }
  double of(const Noise& noise) const {
    double sum = 0;
    for (const Found& found : all_) sum += follow(found, noise).nats();
    return sum;
  }

 private:
  const std::vector<Found>& all_;
};

void print(const std::vector<Found>& all, const Noise& noise) {
  for (const Found& found : all) {
    const Followed followed = follow(found, noise);
    const auto row = [&](const char* what, const tracker::Misfits& misfits, double unit, const char* name) {
      if (misfits.n == 0) return;
      const double n = static_cast<double>(misfits.n);
      fmt::print("{:<9} {:<9} (off / stated)^2 {:.3f}, off {:.3f} {} RMS, {} looks\n", found.name, what,
                 misfits.sum.normalised / n, std::sqrt(misfits.sum.square / n) * unit, name, misfits.n);
    };
    row("places", followed.places, 1000, "mm");
    row("headings", followed.headings, 57.2958, "deg");
    fmt::print("{:<9} LEDs' noise {:.2f} of the stated, {} jumped, {:.4f} nats\n", found.name, followed.led_noise,
               followed.jumped, followed.nats());
  }
}

void fit(const std::vector<Found>& all) {
  Noise noise;
  const auto function = cv::makePtr<Unlikely>(all);
  cv::Mat at(1, static_cast<int>(constants.size()), CV_64F), step(at.size(), CV_64F, cv::Scalar(1.5));
  for (std::size_t i = 0; i < constants.size(); ++i)
    at.at<double>(static_cast<int>(i)) = std::log(constants[i].of(noise));
  const double before = function->of(noise);
  double after = before;
  // From where it ends it starts again, stepping the other way, until that gains nothing.
  for (double sign = 1, gained = 1; gained > 1e-3; sign = -sign) {
    const auto solver =
        cv::DownhillSolver::create(function, sign * step, {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 400, 1e-5});
    gained = after - solver->minimize(at);
    after -= gained;
  }
  for (std::size_t i = 0; i < constants.size(); ++i)
    constants[i].of(noise) = std::exp(at.at<double>(static_cast<int>(i)));
  fmt::print("{:.4f} nats a look before, {:.4f} after\n", before, after);
  for (const Constant& constant : constants) {
    Noise now;
    const double found = constant.of(noise);
    const auto times = [&](double factor) {
      Noise other = noise;
      constant.of(other) = factor * found;
      return function->of(other) - after;
    };
    fmt::print("{:<23} {:.2g}, now {:.2g}; a quarter costs {:.4f}, half {:.4f}, twice {:.4f}, four times {:.4f}\n",
               constant.name, found, constant.of(now), times(0.25), times(0.5), times(2), times(4));
  }
  print(all, noise);
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 0;
  if (!(seconds > 0)) {
    fmt::print(stderr, "motion_noise SECONDS [--fit]\n");
    return 2;
  }
  try {
    const std::vector<Found> all{in_film(ARKMESH_SOURCE_DIR "/tests/data/kilobot-images/bodyguard_clip.mp4"),
                                 under_emulator(ARKMESH_SOURCE_DIR "/experiments/emulator/hundred.toml", seconds),
                                 under_emulator(ARKMESH_SOURCE_DIR "/experiments/emulator/sky.toml", 3 * seconds)};
    print(all, {});
    if (argc > 2 && std::string(argv[2]) == "--fit") fit(all);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "motion_noise: {}\n", error.what());
    return 1;
  }
}
