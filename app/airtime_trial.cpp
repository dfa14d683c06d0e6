#include "app/airtime_trial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "app/arenas.hpp"
#include "app/joint_run.hpp"
#include "arkmesh/to_robots_t.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/files/scratch_folder.hpp"
#include "hal/platforms/kilobot/layout.hpp"

namespace arkmesh::app {
namespace {

constexpr std::uint64_t words_of_whole = hal::kilobot::groups;
constexpr std::uint64_t second_us = 1'000'000;

void count(SlotNeed& need, std::uint64_t words, std::int64_t second) {
  if (std::exchange(need.second, second) != second) need.second_words = 0;
  need.words += words;
  need.second_words += words;
  need.in_one_s = std::max(need.in_one_s, need.second_words);
}

void count(AirtimeNeed& need, std::span<const std::byte> bytes) {
  to_robots_t said;
  if (said.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) return;
  const std::int64_t second = said.stamp_us / std::int64_t{second_us};
  for (const hal::ToRobot& message : hal::from_message(said)) {
    const std::uint64_t words = message.whole ? words_of_whole : 1;
    count(need.slots[message.slot], words, second);
    count(need.all, words, second);
  }
}

double room_of(const hal::Config& config) {
  const hal::Section arena = config.root().section("arena");
  const std::optional<double> room = words_per_s(arena);
  if (!room) arena.refuse("use", "has no airtime to report; use \"ode\", \"kilobot\" or \"emulated\"");
  return *room;
}

}  // namespace

std::vector<AirtimeNeed> try_airtime(LabFiles labs, double seconds, hal::StopRequest& stop, hal::Progress* progress) {
  std::vector<AirtimeNeed> needs;
  for (const hal::Config& config : read_labs(labs, -1)) {
    const auto name = config.root().section("lab").get("name", std::string());
    needs.push_back({.lab = name, .room = room_of(config)});
    // a lab's own override would win over one for all
    for (const std::string& set : {std::string(R"(arena.use="ode")"), std::string("recorder.log=false"),
                                   fmt::format("run.duration_s={}", seconds)})
      labs.sets.push_back(fmt::format("{}:{}", name, set));
  }
  const hal::ScratchFolder folder("airtime");
  JointRun run(read_labs(labs, -1), folder.path());
  std::vector<std::unique_ptr<hal::Bus::Subscription>> heard;
  for (std::size_t i = 0; i < run.size(); ++i) {
    const hal::ArenaInfo& info = run.lab(i).arena().info();
    needs[i].robots = info.robots.size();
    needs[i].layout = hal::kilobot::name_of(hal::kilobot::layout_of(info));
    heard.push_back(run.lab(i).bus().subscribe(
        hal::channel::to_robots,
        [need = &needs[i]](std::string_view, std::span<const std::byte> bytes) { count(*need, bytes); }));
  }
  const nlohmann::json result = run.run(stop, progress);
  if (!run.finished()) throw std::runtime_error(result.value("ended", "the trial ended early"));
  for (std::size_t i = 0; i < run.size(); ++i) {
    hal::Arena& arena = run.lab(i).arena();
    needs[i].air = arena.robots().airtime();
    const lab::RobotBook& book = run.lab(i).runner().robot_book();
    needs[i].anew = book.words_anew() + words_of_whole * book.parameters_anew();
    needs[i].seconds = static_cast<double>(arena.clock().now().count()) * 1e-6;
  }
  return needs;
}

}  // namespace arkmesh::app
