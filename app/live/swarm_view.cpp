#include "app/live/swarm_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/robot_texts_t.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/label.hpp"
#include "view/view_config.hpp"

namespace arkmesh::app {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

constexpr double slowest = 1.0 / 16, fastest = 1024;
constexpr auto text_each = 50ms;  // of wall time: a viewer gets 30 samples a second
constexpr std::size_t max_text_bytes = 64 << 10, max_name = 32;
constexpr auto behind_at_most = 250ms;  // a machine that is too slow for the pace does not catch up later

struct Button {
  const char *name, *words, *title;
};
constexpr std::array buttons = {
    Button{"pause", "Pause", "Pause (key P)"},
    Button{"resume", "Resume", "Resume (key R)"},
    Button{"restart", "Restart", "Restart with the same seed and the current program files"},
    Button{"next_seed", "Next seed", "Restart with the next seed"},
    Button{"slower", "Slower", "Half as fast"},
    Button{"faster", "Faster", "Twice as fast"}};

std::string line_by_line(const std::string& text) {
  std::string out = text;
  std::ranges::replace_if(
      out, [](char c) { return c != '\n' && !hal::is_printable(c); }, '?');
  return out;
}

}  // namespace

SwarmView::SwarmView(hal::EventLoop& loop, SwarmViewOptions options)
    : options_(std::move(options)),
      name_(hal::printable(options_.swarm.program.name(), max_name)),
      time_(loop),
      server_(loop, {.port = view::ViewConfig().port}, *this) {
  begin();
}

void SwarmView::begin() {
  now_ = next_ = hal::LabTime{0};
  due_ = speed_since_ = time_.now();
  speed_from_ = hal::LabTime{0};
  failure_.clear();
  text_.clear();
  paused_ = false;
  swarm_.reset();  // before the next: its program's text is one for all who run it
  try {
    swarm_ = std::make_unique<sim_ode::ControllerSwarm>(options_.swarm);
  } catch (const sim_ode::ProgramError& error) {
    return fail(error.what());
  }
  server_.tell(0, 0, fmt::format("begins, seed {}", options_.swarm.seed));
  show_arena();
  step();
}

void SwarmView::fail(const std::string& why) {
  failure_ = why;
  server_.tell(0, now_.count(), "failed: " + why);
  refresh();
}

bool SwarmView::is_over() const {
  return options_.seconds && static_cast<double>(next_.count()) > *options_.seconds * 1e6;
}

void SwarmView::step() {
  try {
    swarm_->run_until(next_, [&](const hal::PoseFrame& frame) { show_frame(frame); });
  } catch (const std::runtime_error& error) {
    return fail(error.what());
  }
  now_ = next_;
  next_ += swarm_->arena().info().frame_period;
  due_ += std::chrono::duration_cast<hal::TimePoint::duration>(swarm_->arena().info().frame_period / options_.pace);
  if (due_ < time_.now() - behind_at_most) due_ = time_.now();
  show_text();
  if (is_over()) {
    server_.tell(0, now_.count(), fmt::format("ended after {} s", *options_.seconds));
    refresh();
  }
}

void SwarmView::run(hal::StopRequest& stop) {
  while (!stop.stopped()) {
    const bool goes_on = swarm_ && failure_.empty() && !paused_ && !is_over();
    if (goes_on && time_.now() >= due_) step();
    time_.wait_for_anything(goes_on ? std::min(due_, time_.now() + 200ms) : time_.now() + 200ms);
  }
}

template <class Message>
void SwarmView::show(const std::string& channel, const Message& message, view::Part part) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  server_.show(0, now_.count(), channel, bytes, part);
}

void SwarmView::show_arena() {
  show(hal::channel::arena, hal::to_message(swarm_->arena().info()));
}

void SwarmView::show_frame(const hal::PoseFrame& frame) {
  now_ = frame.stamp;
  for (const pose_frame_t& part : hal::to_messages(frame))
    show(hal::channel::poses, part,
         {.frame = static_cast<std::int32_t>(frame.number), .part = part.part, .parts = part.parts});
}

// Several frames' together, so that no message is skipped by the samples that viewers get.
void SwarmView::show_text() {
  std::ranges::move(swarm_->take_text(), std::back_inserter(text_));
  if (text_.empty() || time_.now() - text_shown_ < text_each) return;
  text_shown_ = time_.now();
  robot_texts_t message;
  message.stamp_us = now_.count();
  message.n_lost = static_cast<std::int64_t>(swarm_->lost_text());
  std::size_t bytes = 0;
  for (const auto& [robot, at_us, text] : text_) {
    if ((bytes += text.size()) > max_text_bytes) {
      message.n_lost += static_cast<std::int64_t>(text.size());
      continue;
    }
    robot_text_t& one = message.texts.emplace_back();
    one.robot = robot;
    one.at_us = at_us;
    one.text = line_by_line(text);
  }
  message.n_texts = static_cast<std::int32_t>(message.texts.size());
  text_.clear();
  show(hal::channel::robot_texts, message);
}

std::string SwarmView::state() const {
  const std::string of = fmt::format("seed {}, at most {:g}x real time", options_.swarm.seed, options_.pace);
  if (!failure_.empty()) return fmt::format("{}: {}", of, failure_);
  return fmt::format("{}: {}", paused_ ? "paused" : is_over() ? "over" : "running", of);
}

void SwarmView::refresh() {
  const hal::TimePoint now = time_.now();
  const double wall_s = std::chrono::duration<double>(now - speed_since_).count();
  if (wall_s >= 0.4) {
    speed_ = static_cast<double>((now_ - std::exchange(speed_from_, now_)).count()) * 1e-6 / wall_s;
    speed_since_ = now;
  }
  lab_status_t status{};
  status.lab = name_;
  status.phase = !failure_.empty() || is_over() ? lab_status_t::ended
                 : paused_                      ? lab_status_t::waiting
                                                : lab_status_t::going_on;
  status.outcome = !failure_.empty() ? lab_status_t::failed : is_over() ? lab_status_t::finished : lab_status_t::open;
  status.state = state();
  status.wanted = lab_status_t::run;
  status.stamp_us = now_.count();
  status.speed = speed_;
  status.can_wait = true;
  if (swarm_) status.counters = hal::to_message(swarm_->arena().counters());
  status.n_counters = static_cast<std::int32_t>(status.counters.size());
  show(hal::channel::status, status);
}

json SwarmView::about() {
  json commands = json::array();
  for (const Button& button : buttons) commands.push_back({button.name, button.words, button.title});
  return {{"mode", "live"}, {"labs", {name_}},     {"control", true},
          {"run", name_},   {"emulator", {false}}, {"commands", std::move(commands)}};
}

void SwarmView::command(const json& what, view::Answer& answer) {
  const auto name = "/command/name"_json_pointer;
  const std::string wish = what.contains(name) && what[name].is_string() ? what[name].get<std::string>() : "";
  if (wish == "pause" || wish == "resume") {
    paused_ = wish == "pause";
    due_ = time_.now();
  } else if (wish == "restart" || wish == "next_seed") {
    if (wish == "next_seed") ++options_.swarm.seed;
    begin();
  } else if (wish == "slower" || wish == "faster") {
    options_.pace = std::clamp(wish == "slower" ? options_.pace / 2 : options_.pace * 2, slowest, fastest);
    due_ = time_.now();
  } else {
    return answer.refuse("Unknown command; commands are pause, resume, restart, next_seed, slower and faster.");
  }
  refresh();
  answer.done();
}

void SwarmView::request(const json& what, view::Answer& answer) {
  if (!what.contains("series")) return answer.refuse("This swarm is running; earlier moments are not recorded.");
  if (!answer.done({{"series", json::array()}})) answer.refuse("the answer cannot be sent now; try again later");
}

}  // namespace arkmesh::app
