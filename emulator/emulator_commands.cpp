// What can happen on an emulated testbed, as text: for the control port and for the events of an emulator's file.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "emulator/emulator.hpp"

namespace arkmesh::emulator {
namespace {

constexpr double rad_per_degree = std::numbers::pi / 180;

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> out;
  while (true) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return out;
    line.remove_prefix(begin);
    const std::size_t end = std::min(line.find_first_of(" \t\r"), line.size());
    out.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

// Not a number, or none that is finite: nothing.
std::optional<double> number(std::string_view text) {
  double out = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(out)) return std::nullopt;
  return out;
}

std::optional<int> whole(std::string_view text, int below) {
  int out = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (error != std::errc{} || end != text.data() + text.size() || out < 0 || out >= below) return std::nullopt;
  return out;
}

std::string unknown(std::string_view what) {
  return fmt::format("error: '{}' is not a command; `help` lists the commands", what);
}

}  // namespace

std::string_view Emulator::help_text() {
  return "camera NAME ok|frozen|gone|dark; camera NAME move DX_M DY_M [TURN_DEG]; ohc unplug|plug; ohc garbage BYTES; "
         "ohc noise SHARE; ohc stall SECONDS; nodes cut; nodes garbage BYTES; nodes stall SECONDS; "
         "say run|pause|reset|sleep|voltage|charge|boot|stop; robot N take; robot N put X_M Y_M [HEADING_DEG]; robot "
         "N kill|revive; "
         "robot N cover SECONDS; robot id:ID ...; swap A B SECONDS; status; help";
}

std::string Emulator::command(std::string_view line) {
  const std::vector<std::string_view> words = split(line.substr(0, 400));
  if (words.empty()) return "error: an empty command; `help` lists the commands";
  if (words[0] == "help") return std::string(help_text());
  if (words[0] == "status") return status();
  if (words[0] == "camera" && words.size() >= 3) return camera_command(words[1], words);
  if (words[0] == "ohc" && words.size() >= 2)
    return nodes_ ? "error: these robots have no overhead controller; `nodes` disturbs theirs" : ohc_command(words);
  if (words[0] == "nodes" && words.size() >= 2) return nodes_command(words);
  if (words[0] == "robot" && words.size() >= 3) return robot_command(words);
  if (words[0] == "swap") return swap(words);
  if (words[0] == "say" && words.size() == 2) return say(words);
  return unknown(line.substr(0, 100));
}

std::string Emulator::camera_command(std::string_view name, const std::vector<std::string_view>& words) {
  const auto eye = std::ranges::find_if(eyes_, [name](const Eye& one) { return one.camera->settings().name == name; });
  if (eye == eyes_.end()) return fmt::format("error: there is no camera '{}'", name);
  if (words[2] == "move") {
    const auto dx = number(words.size() > 3 ? words[3] : ""), dy = number(words.size() > 4 ? words[4] : ""),
               turn = number(words.size() > 5 ? words[5] : "0");
    if (!dx || !dy || !turn) return "error: `camera NAME move` needs two distances in metres and, optionally, degrees";
    CameraPose pose = eye->camera->pose();
    pose.x_m += *dx;
    pose.y_m += *dy;
    pose.look_x_m += *dx;
    pose.look_y_m += *dy;
    pose.roll_rad += *turn * rad_per_degree;
    try {
      eye->camera->move_to(pose);
    } catch (const std::invalid_argument& error) {
      return fmt::format("error: camera {} {}", name, error.what());
    }
    return "ok";
  }
  if (words[2] != "ok" && words[2] != "frozen" && words[2] != "gone" && words[2] != "dark") return unknown(words[2]);
  if (words[2] == "ok") {
    // also back to its place
    const CameraPose& first = eye->camera->settings().pose;
    const CameraPose& pose = eye->camera->pose();
    if (pose.x_m != first.x_m || pose.y_m != first.y_m || pose.roll_rad != first.roll_rad) eye->camera->move_to(first);
    eye->gone = eye->dark = eye->frozen = false;
  }
  if (words[2] == "gone") eye->gone = true;
  if (words[2] == "dark") eye->dark = true;
  if (words[2] == "frozen" && !eye->frozen) {
    eye->last.release();
    eye->frozen = true;
  }
  counters_.add(fmt::format("emulator.camera_{}", words[2]));
  return "ok";
}

std::string Emulator::ohc_command(const std::vector<std::string_view>& words) {
  const std::int64_t now_us = now().count();
  if (words[1] == "unplug") {
    serial_.unplug(now_us);
  } else if (words[1] == "plug") {
    serial_.plug_in(now_us);
  } else if (words[1] == "garbage") {
    const auto bytes = whole(words.size() > 2 ? words[2] : "", OhcSerialPort::max_waiting + 1);
    if (!bytes)
      return fmt::format("error: `ohc garbage` needs a number of bytes, at most {}", OhcSerialPort::max_waiting);
    serial_.garbage(static_cast<std::size_t>(*bytes), now_us);
  } else if (words[1] == "stall") {
    const auto seconds = number(words.size() > 2 ? words[2] : "");
    if (!seconds || *seconds < 0 || *seconds > 3600) return "error: `ohc stall` needs seconds, at most 3600";
    serial_.stall(static_cast<std::int64_t>(*seconds * 1e6), now_us);
  } else if (words[1] == "noise") {
    const auto share = number(words.size() > 2 ? words[2] : "");
    if (!share || *share < 0 || *share > 1) return "error: `ohc noise` needs a share of the bytes, 0 to 1";
    serial_.set_noise(*share);
  } else {
    return unknown(words[1]);
  }
  return "ok";
}

std::string Emulator::nodes_command(const std::vector<std::string_view>& words) {
  if (!nodes_) return "error: Kilobots have no nodes; `ohc` disturbs their overhead controller";
  if (words[1] == "cut") {
    nodes_->cut();
  } else if (words[1] == "garbage") {
    constexpr int most = 1 << 20;
    const auto bytes = whole(words.size() > 2 ? words[2] : "", most + 1);
    if (!bytes) return fmt::format("error: `nodes garbage` needs a number of bytes, at most {}", most);
    nodes_->garbage(static_cast<std::size_t>(*bytes), config_.seed);
  } else if (words[1] == "stall") {
    const auto seconds = number(words.size() > 2 ? words[2] : "");
    if (!seconds || *seconds < 0 || *seconds > 3600) return "error: `nodes stall` needs seconds, at most 3600";
    nodes_->stall(hal::LabTime{static_cast<std::int64_t>(*seconds * 1e6)});
  } else {
    return unknown(words[1]);
  }
  return "ok";
}

// By its number, or as "id:" and the id that it alone bears.
std::optional<int> Emulator::robot_of(std::string_view word) const {
  if (!word.starts_with("id:")) return whole(word, robots());
  const auto id = whole(word.substr(3), 65'536);
  std::optional<int> robot;
  for (const Truth& one : truth()) {
    if (!id || one.id != *id) continue;
    if (robot) return {};
    robot = one.robot;
  }
  return robot;
}

std::string Emulator::robot_command(const std::vector<std::string_view>& words) {
  const auto robot = robot_of(words[1]);
  if (!robot) return fmt::format("error: there is no robot '{}'; they are numbered 0 to {}", words[1], robots() - 1);
  const hal::Pose pose = look()[static_cast<std::size_t>(*robot)].pose;
  seen_at_ = hal::LabTime{-1};
  if (words[2] == "take" || words[2] == "put") {
    if (is_lifted(*robot)) return fmt::format("error: robot {} is lifted by hand", *robot);
    if (words[2] == "take") {
      arena_->take_off(*robot);
      return "ok";
    }
    const auto x = number(words.size() > 3 ? words[3] : ""), y = number(words.size() > 4 ? words[4] : ""),
               heading = words.size() > 5 ? number(words[5]) : pose.heading_rad / rad_per_degree;
    if (!x || !y || !heading)
      return "error: `robot N put` needs x and y in metres and, optionally, a heading in degrees";
    const std::string error =
        arena_->put(*robot, {*x, *y, std::remainder(*heading * rad_per_degree, 2 * std::numbers::pi)});
    return error.empty() ? "ok" : "error: " + error;
  }
  if (words[2] == "cover") {
    const auto seconds = number(words.size() > 3 ? words[3] : "");
    if (!seconds || *seconds <= 0 || *seconds > 3600) return "error: `robot N cover` needs seconds, at most 3600";
    coverings_.push_back({{pose.x_m, pose.y_m}, now() + hal::LabTime{static_cast<std::int64_t>(*seconds * 1e6)}});
    return "ok";
  }
  if (words[2] != "kill" && words[2] != "revive") return unknown(words[2]);
  arena_->set_power(*robot, words[2] == "revive");
  if (nodes_) nodes_->set_power(*robot, words[2] == "revive");
  return "ok";
}

// Two hands take two robots; each is put where the other one was, facing as the other one did.
std::string Emulator::swap(const std::vector<std::string_view>& words) {
  const auto a = whole(words.size() > 1 ? words[1] : "", robots()),
             b = whole(words.size() > 2 ? words[2] : "", robots());
  const auto seconds = number(words.size() > 3 ? words[3] : "1.5");
  if (!a || !b || *a == *b || !seconds || *seconds <= 0 || *seconds > 3600)
    return "error: `swap` needs two robots and seconds, at most 3600";
  if (is_lifted(*a) || is_lifted(*b)) return "error: one of the two robots is lifted by hand";
  const std::vector<sim_ode::SimulatedArena::Seen> seen = look();
  const sim_ode::SimulatedArena::Seen &first = seen[static_cast<std::size_t>(*a)],
                                      &second = seen[static_cast<std::size_t>(*b)];
  if (!first.in_arena || !second.in_arena) return "error: one of the two robots is not in the arena";
  const hal::LabTime until = now() + hal::LabTime{static_cast<std::int64_t>(*seconds * 1e6)};
  for (const auto& [robot, from, to] : {std::tuple{*a, first.pose, second.pose}, {*b, second.pose, first.pose}}) {
    arena_->take_off(robot);
    lifted_.push_back({.robot = robot, .to = to, .until = until});
    coverings_.push_back({{from.x_m, from.y_m}, until});
  }
  seen_at_ = hal::LabTime{-1};
  return "ok";
}

// As a host would, on an emulated testbed without one: the message repeats until the next packet.
std::string Emulator::say(const std::vector<std::string_view>& words) {
  if (nodes_) return nodes_->say(words[1]) ? "ok" : unknown(words[1]);
  constexpr std::pair<std::string_view, std::uint8_t> types[] = {{"run", 0x88},   {"pause", 0x85},   {"reset", 0x83},
                                                                 {"sleep", 0x84}, {"voltage", 0x87}, {"charge", 0x86},
                                                                 {"boot", 0x80},  {"stop", 0}};
  const auto* const type = std::ranges::find(types, words[1], &std::pair<std::string_view, std::uint8_t>::first);
  if (type == std::end(types)) return unknown(words[1]);
  std::array<std::uint8_t, OhcDevice::packet_bytes> packet{};
  packet[0] = 0x55;
  packet[1] = type->second == 0 ? 0 : 2;
  packet[11] = type->second;
  for (std::size_t i = 0; i + 1 < packet.size(); ++i) packet.back() ^= packet[i];
  if (serial_free() < packet.size()) return "error: the serial port's buffer is full; try again";
  serial_.write(packet, now().count());
  return serial_.plugged() ? "ok" : "error: the overhead controller is unplugged";
}

std::string Emulator::status() const {
  std::string out = fmt::format("time_s={:.3f}", static_cast<double>(now().count()) * 1e-6);
  for (const Eye& eye : eyes_)
    out += fmt::format(" {}={}", eye.camera->settings().name,
                       eye.gone     ? "gone"
                       : eye.dark   ? "dark"
                       : eye.frozen ? "frozen"
                                    : "ok");
  if (!nodes_) out += fmt::format(" ohc={}", serial_.plugged() ? "plugged" : "unplugged");
  const hal::Counters totals = counters();
  for (const auto& [name, total] : totals.all()) out += fmt::format(" {}={}", name, total);
  return out;
}

}  // namespace arkmesh::emulator
