// The page of a swarm that runs one program, without a lab: in step with the wall, with what robots print; viewers who
// may control it pause it, begin it anew and change its pace.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/event_loop.hpp"
#include "hal/stop_request.hpp"
#include "hal/time/loop_time.hpp"
#include "sim_ode/controller_swarm.hpp"
#include "view/server.hpp"

namespace arkmesh::app {

struct SwarmViewOptions {
  sim_ode::SwarmOptions swarm;
  double pace = 1;                // seconds of lab time in one of the wall
  std::optional<double> seconds;  // of lab time; none: until somebody stops it
};

class SwarmView final : public view::Desk {
 public:
  // Listens at once, and begins the run. A program that does not compile is shown as a run that has failed: when it is
  // mended, the run begins anew. `loop` outlives the page. Throws hal::ConfigError when the options do not go together,
  // std::runtime_error when no port is free.
  SwarmView(hal::EventLoop& loop, SwarmViewOptions options);

  // With the token of control.
  std::string url() const { return server_.url_with_token(); }
  // Until somebody stops it.
  void run(hal::StopRequest& stop);
  // Why the newest run has failed; empty: it has not.
  const std::string& failure() const { return failure_; }

  nlohmann::json about() override;
  void command(const nlohmann::json& what, view::Answer& answer) override;
  void request(const nlohmann::json& what, view::Answer& answer) override;
  void refresh() override;

 private:
  // Compiles the program anew, if it has changed.
  void begin();
  void step();
  bool is_over() const;
  void fail(const std::string& why);
  void show_arena();
  void show_frame(const hal::PoseFrame& frame);
  void show_text();
  std::string state() const;
  template <class Message>
  void show(const std::string& channel, const Message& message, view::Part part = {});

  SwarmViewOptions options_;
  const std::string name_;
  hal::LoopTime time_;
  view::Server server_;
  std::unique_ptr<sim_ode::ControllerSwarm> swarm_;  // null: it could not be made
  hal::LabTime now_{0}, next_{0};                    // of the newest frame, and of the next
  hal::TimePoint due_{};                             // when the next frame is
  hal::TimePoint text_shown_{};
  std::vector<sim_ode::ProgramText::Piece> text_;  // not shown yet
  bool paused_ = false;
  std::string failure_;
  double speed_ = 0;  // lab time in a second of wall time, lately
  hal::TimePoint speed_since_{};
  hal::LabTime speed_from_{0};
};

}  // namespace arkmesh::app
