#include "sim_ode/host/reports/swarm_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "hal/fixed_math.hpp"
#include "hal/overlay/led_name.hpp"

namespace arkmesh::sim_ode {
namespace {

Spread spread(const std::vector<double>& values) {
  if (values.empty()) return {};
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {*low, std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size()), *high};
}

std::string centimetres(const std::vector<double>& values_m) {
  const Spread s = spread(values_m);
  return fmt::format("{:.1f} cm on average ({:.1f} to {:.1f})", s.mean * 100, s.low * 100, s.high * 100);
}

}  // namespace

std::vector<double> nearest_neighbours(const hal::PoseFrame& frame) {
  // along x, so that a search ends once the difference in x alone is larger than what was found
  std::vector<const hal::Pose*> by_x;
  for (const hal::Observation& robot : frame.robots) by_x.push_back(&robot.pose);
  std::stable_sort(by_x.begin(), by_x.end(), [](const hal::Pose* a, const hal::Pose* b) { return a->x_m < b->x_m; });
  std::vector<double> nearest;
  if (by_x.size() < 2) return nearest;
  for (std::size_t i = 0; i < by_x.size(); ++i) {
    double best = HUGE_VAL;
    const auto compare = [&](std::size_t k) {
      const double dx = by_x[k]->x_m - by_x[i]->x_m;
      if (std::abs(dx) >= best) return false;
      best = std::min(best, hal::fixed::hypot(dx, by_x[k]->y_m - by_x[i]->y_m));
      return true;
    };
    for (std::size_t k = i + 1; k < by_x.size() && compare(k);) ++k;
    for (std::size_t k = i; k > 0 && compare(k - 1);) --k;
    nearest.push_back(best);
  }
  return nearest;
}

void SwarmReport::look(const hal::PoseFrame& frame) {
  if (frames_++ == 0) {
    first_ = last_ = frame;
    path_m_.assign(frame.robots.size(), 0);
    changes_.assign(frame.robots.size(), 0);
  }
  // Once through all robots: frames come often, and many robots' frames are larger than the processor's cache.
  auto shown = shown_;
  for (std::size_t i = 0; i < frame.robots.size(); ++i) {
    const hal::Observation& now = frame.robots[i];
    hal::Observation& before = last_.robots[i];
    const double dx = now.pose.x_m - before.pose.x_m, dy = now.pose.y_m - before.pose.y_m;
    path_m_[i] += std::sqrt(dx * dx + dy * dy);
    changes_[i] += now.led != before.led;
    ++shown[static_cast<std::size_t>(now.led)];
    before = now;
  }
  shown_ = shown;
  last_.stamp = frame.stamp;
  last_.number = frame.number;
}

std::string SwarmReport::text(const hal::Counters& counters) const {
  const double robots = static_cast<double>(last_.robots.size());
  std::array<int, hal::led_names.size()> at_end{};
  for (const hal::Observation& robot : last_.robots) ++at_end[static_cast<std::size_t>(robot.led)];
  const std::uint64_t total = std::accumulate(shown_.begin(), shown_.end(), std::uint64_t{0});

  std::string text = "colours    ";
  for (std::size_t i = 0; i < hal::led_names.size(); ++i)
    if (shown_[i] > 0)
      text += fmt::format("{} {:.0f} % ", hal::led_names[i],
                          100.0 * static_cast<double>(shown_[i]) / static_cast<double>(total));
  text += "of the time; at the end";
  for (std::size_t i = 0; i < hal::led_names.size(); ++i)
    if (at_end[i] > 0) text += fmt::format(" {} {}", at_end[i], hal::led_names[i]);
  const std::uint64_t changes = std::accumulate(changes_.begin(), changes_.end(), std::uint64_t{0});
  if (robots > 0) text += fmt::format("; {:.1f} changes per robot", static_cast<double>(changes) / robots);

  std::vector<double> displaced_m;
  for (std::size_t i = 0; i < last_.robots.size(); ++i)
    displaced_m.push_back(hal::fixed::hypot(last_.robots[i].pose.x_m - first_.robots[i].pose.x_m,
                                            last_.robots[i].pose.y_m - first_.robots[i].pose.y_m));
  text += fmt::format("\npaths      {}\ndisplaced  {}\n", centimetres(path_m_), centimetres(displaced_m));
  if (last_.robots.size() > 1)
    text += fmt::format("nearest    {} at the start\n           {} at the end\n",
                        centimetres(nearest_neighbours(first_)), centimetres(nearest_neighbours(last_)));

  const auto each = [&](const char* name) { return robots > 0 ? static_cast<double>(counters[name]) / robots : 0.0; };
  text += fmt::format("messages   {} sent ({:.1f} per robot), {} heard ({:.1f} per robot)\n", counters["infrared.sent"],
                      each("infrared.sent"), counters["infrared.received"], each("infrared.received"));
  // The rest of what the arena counted, where there is any.
  for (const auto& [name, count] : counters.all())
    if (count > 0 && name != "infrared.sent" && name != "infrared.received")
      text += fmt::format("           {} {}\n", name, count);
  return text;
}

}  // namespace arkmesh::sim_ode
