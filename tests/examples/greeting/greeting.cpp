#include "tests/examples/greeting/greeting.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

namespace arkmesh::examples::greeting {
namespace {

constexpr std::int64_t max_answers = 1'000'000;

}  // namespace

void Greeting::begin(lab::Lab& lab) {
  lab.declare({.name = "answers", .length = 1, .low = 0, .high = max_answers});
  lab.publish("answers", {0});
}

void Greeting::on_heard(lab::Lab& lab, std::span<const hal::FromRobot> messages) {
  for (const hal::FromRobot& said : messages)
    lab.row("answers", "time_s,robot,value",
            fmt::format("{},{},{}", std::chrono::duration<double>(lab.now()).count(), said.robot, said.value));
  lab.counts().add("answers", messages.size());
  answers_ = std::min(max_answers, answers_ + std::ssize(messages));
  lab.publish("answers", {answers_});
}

void Greeting::on_period(lab::Lab& lab) {
  const auto value = static_cast<std::uint16_t>(lab.period() % lab.arena().values);
  for (const hal::RobotId robot : lab.arena().robots) lab.say({.robot = robot, .value = value});
  lab.counts().add("greetings", lab.arena().robots.size());
}

bool Greeting::finished(const lab::Lab& lab) const {
  return std::ranges::all_of(lab.labs(), [&](const std::string& each) {
    const auto& answers = lab.field(each, "answers");
    return !answers.empty() && answers[0] >= enough_;
  });
}

app::CatalogueEntry greeting() {
  return {"greeting",
          [](const hal::Section& settings, const std::vector<std::string>&) -> std::unique_ptr<lab::Scenario> {
            return std::make_unique<Greeting>(settings.get("answers", 10, {.range = {1, max_answers}}));
          }};
}

}  // namespace arkmesh::examples::greeting
