// The emulated testbed: an arena of simulated robots, cameras over it, an overhead controller at the end of a serial
// line, hands and faults. Steps as its caller says, without wall time: equal calls give equal pictures.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "emulator/aseba_nodes.hpp"
#include "emulator/camera.hpp"
#include "emulator/emulator_config.hpp"
#include "emulator/ohc_serial_port.hpp"
#include "hal/config/config.hpp"
#include "sim_ode/simulated_arena.hpp"

namespace arkmesh::emulator {

class Emulator {
 public:
  // Reads [emulator], [arena] and [arena.ode]. Throws ConfigError.
  explicit Emulator(const hal::Section& root);

  const EmulatorConfig& config() const { return config_; }
  hal::LabTime now() const { return arena_->clock().now(); }
  // Lets time pass; events of the file happen on the way. Never decreases. Throws std::runtime_error when a robot's
  // program fails.
  void advance_to(hal::LabTime t);

  // Bytes that the host writes to the overhead controller now. More than serial_free() would be lost.
  void write_serial(std::span<const std::uint8_t> bytes) { serial_.write(bytes, now().count()); }
  std::size_t serial_free() const { return serial_.free(); }
  // Hears each message that the overhead controller sent, with its times since the emulator began.
  void listen(std::function<void(const sim_ode::Transmission&)> listener) { serial_.listen(std::move(listener)); }
  bool ohc_plugged() const { return serial_.plugged(); }
  // What robots with nodes have in place of a controller; others: none.
  AsebaNodes* nodes() { return nodes_ ? &*nodes_ : nullptr; }

  // What that camera sees now; false: it is gone.
  std::size_t cameras() const { return eyes_.size(); }
  const Camera& camera(std::size_t number) const { return *eyes_[number].camera; }
  bool is_gone(std::size_t number) const { return eyes_[number].gone; }
  bool picture(std::size_t number, cv::Mat& out);

  // One line of the control port; see help_text. "ok", an answer, or "error: " and a sentence.
  std::string command(std::string_view line);
  static std::string_view help_text();

  // What only the emulator knows.
  struct Truth {
    int robot = 0;         // its number in the simulation
    std::uint16_t id = 0;  // kilo_uid
    hal::Led led = hal::Led::off;
    sim_ode::SimulatedArena::Seen seen;
  };
  std::vector<Truth> truth() const;
  int robots() const { return static_cast<int>(arena_->info().robots.size()); }
  // Everything that was lost, refused or spoilt.
  hal::Counters counters() const;

 private:
  struct Eye {
    std::unique_ptr<Camera> camera;
    bool gone = false, dark = false, frozen = false;
    cv::Mat last;  // what it shows while it is frozen
  };
  // A robot that is in somebody's hands, and the place where it is to stand again.
  struct Lifted {
    int robot;
    hal::Pose to;
    hal::LabTime until;
    int tries = 0;
  };
  struct Covering {
    Hand hand;
    hal::LabTime until;
  };

  std::string camera_command(std::string_view name, const std::vector<std::string_view>& words);
  std::string nodes_command(const std::vector<std::string_view>& words);
  std::string ohc_command(const std::vector<std::string_view>& words);
  std::optional<int> robot_of(std::string_view word) const;
  std::string robot_command(const std::vector<std::string_view>& words);
  std::string swap(const std::vector<std::string_view>& words);
  std::string say(const std::vector<std::string_view>& words);
  std::string status() const;
  bool is_lifted(int robot) const;
  void put_down();
  const std::vector<sim_ode::SimulatedArena::Seen>& look() const;

  EmulatorConfig config_;
  OhcSerialPort serial_;
  std::unique_ptr<sim_ode::SimulatedArena> arena_;
  std::optional<AsebaNodes> nodes_;
  std::vector<Eye> eyes_;
  std::size_t next_event_ = 0;
  std::vector<Lifted> lifted_;
  std::vector<Covering> coverings_;
  mutable std::vector<sim_ode::SimulatedArena::Seen> seen_;
  mutable hal::LabTime seen_at_{-1};
  hal::Counters counters_;
};

}  // namespace arkmesh::emulator
