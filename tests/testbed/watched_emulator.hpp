// An emulated testbed whose pictures a monitor looks at, one after the other, in the test's hand.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <filesystem>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "emulator/emulator.hpp"
#include "hal/config/config.hpp"
#include "testbed/arena_monitor.hpp"
#include "tracker/camera/calibration_file.hpp"

namespace arkmesh::tests {

// As a lab reads them, at a testbed whose controller is the test's.
inline testbed::KilobotSettings lab_settings(const hal::Config& config) {
  const hal::Section arena = config.root().section("arena");
  return testbed::read_kilobot_settings(arena, "lab", testbed::read_cameras(arena.section("kilobot")).size());
}

// An emulated testbed as the testbed: its camera is what the monitor sees, and what the monitor asks is said by its
// overhead controller.
class EmulatedTestbed {
 public:
  explicit EmulatedTestbed(const std::string& text)
      : config_(hal::Config::from_text(text, "emulator.toml")), emulator_(config_.root()) {
    emulator_.advance_to(hal::LabTime(2'500'000));
  }

  emulator::Emulator& emulator() { return emulator_; }
  std::size_t late_pictures = 0;  // the monitor gets those of so many looks ago
  double scale = 1;               // of its pictures

  std::unique_ptr<hal::kilobot::RobotMonitor> monitor(const std::string& lab,
                                                      const std::filesystem::path& calibration) {
    std::vector<tracker::NamedCamera> cameras;
    for (std::size_t k = 0; k < emulator_.cameras(); ++k) {
      const auto& model = emulator_.camera(k).model_at_first();
      tracker::CameraData data;
      data.lens.width_px = model.width_px();
      data.lens.height_px = model.height_px();
      for (int i = 0; i < 9; ++i)
        data.lens.matrix[i] = model.matrix().val[i], data.rotation[i] = model.rotation().val[i];
      data.lens.distortion.assign(model.distortion().begin(), model.distortion().end());
      for (int i = 0; i < 3; ++i) data.translation_m[i] = model.translation()[i];
      cameras.push_back({emulator_.camera(k).settings().name, data});
    }
    tracker::write_calibrations(calibration, cameras);
    const auto config = hal::Config::from_text(lab, "lab.toml");
    return testbed::make_arena_monitor(lab_settings(config), {}, [this](const tracker::CameraRequest& camera) {
      return std::make_unique<Feed>(*this, static_cast<std::size_t>(camera.source.back() - '0'));
    });
  }

  // The next picture, a tenth of a second later; meanwhile the controller says what the monitor asks.
  void next(hal::kilobot::RobotMonitor& monitor) {
    const auto question = monitor.question();
    if (question != asked_) {
      asked_ = question;
      say(question);
    }
    emulator_.advance_to(emulator_.now() + hal::LabTime(100'000));
    monitor.look(emulator_.now());
  }

  // Robots seen in this very frame whose id is another's, judged by what only the emulator knows.
  int wrong_ids(hal::kilobot::RobotMonitor& monitor, int* named = nullptr) {
    const auto frame = monitor.latest();
    if (!frame) return 0;
    int wrong = 0;
    for (const hal::Observation& seen : frame->robots) {
      if (seen.age.count() > 0) continue;
      const auto truth = emulator_.truth();
      const auto robot =
          std::find_if(truth.begin(), truth.end(), [&](const auto& one) { return one.id == seen.robot; });
      if (robot == truth.end() ||
          std::hypot(robot->seen.pose.x_m - seen.pose.x_m, robot->seen.pose.y_m - seen.pose.y_m) > 0.02)
        ++wrong;
    }
    if (named) *named = static_cast<int>(frame->robots.size());
    return wrong;
  }

 private:
  class Feed final : public tracker::CameraFeed {
   public:
    Feed(EmulatedTestbed& testbed, std::size_t camera) : testbed_(testbed), camera_(camera) {}
    cv::Mat newest() override {
      cv::Mat picture;
      if (!testbed_.emulator_.picture(camera_, picture)) return {};
      on_their_way_.emplace_back();
      cv::resize(picture, on_their_way_.back(), {}, testbed_.scale, testbed_.scale);
      if (on_their_way_.size() <= testbed_.late_pictures) return {};
      cv::Mat first = on_their_way_.front();
      on_their_way_.pop_front();
      return first;
    }
    std::string error() const override { return {}; }
    hal::Counters counters() const override { return {}; }

   private:
    std::deque<cv::Mat> on_their_way_;
    EmulatedTestbed& testbed_;
    std::size_t camera_;
  };

  void say(const std::optional<hal::kilobot::Message>& message) {
    std::array<std::uint8_t, 132> packet{};
    packet[0] = 0x55;
    if (message) {
      packet[1] = 2;
      std::copy(message->data.begin(), message->data.end(), packet.begin() + 2);
      packet[11] = message->type;
    }
    for (std::size_t i = 0; i < 131; ++i) packet[131] ^= packet[i];
    emulator_.write_serial(packet);
  }

  hal::Config config_;
  emulator::Emulator emulator_;
  std::optional<hal::kilobot::Message> asked_;
};

inline std::string emulator_text(const std::string& more = "") {
  return fmt::format(
      "[emulator]\nseed = 3\nids = \"shuffled\"\ncamera_port = 0\nohc_port = 0\ncontrol_port = 0\n"
      "[[emulator.camera]]\nname = \"camera0\"\nwidth_px = 800\nheight_px = 640\nz_m = 1.0\n"
      "distortion = [-0.09, 0.02, 0.0006, -0.0004, 0.0]\n{}\n"
      "[arena]\nwidth_m = 0.5\nheight_m = 0.4\nrobots = 8\n[arena.ode]\n"
      "controller = \"{}/tests/sim_ode/controllers/answers.c\"\n",
      more, ARKMESH_SOURCE_DIR);
}

inline std::string lab_text(const std::filesystem::path& calibration, const std::string& more = "") {
  return fmt::format(
      "[arena]\nwidth_m = 0.5\nheight_m = 0.4\nrobots = 8\n[arena.kilobot]\n{}\n"
      "[[arena.kilobot.cameras]]\nsource = \"0\"\ncalibration = \"{}\"\n",
      more, calibration.string());
}

}  // namespace arkmesh::tests
