#include "app/joint_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <stdexcept>

#include "lab/result.hpp"

namespace arkmesh::app {
namespace {

constexpr std::chrono::microseconds step_time{1000};
constexpr std::uint64_t deadlock_steps = 10'000;  // repetition and dead-peer rules have long had their say by then

}  // namespace

JointRun::JointRun(std::vector<hal::Config> configs, const std::filesystem::path& directory) : network_(1) {
  for (hal::Config& config : configs) {
    const std::string name = config.root().section("lab").required_text("name");
    const std::string file = config.file().string();
    if (std::any_of(labs_.begin(), labs_.end(), [&](const auto& m) { return m->session->config().lab == name; }))
      throw hal::ConfigError(fmt::format("{}: lab '{}' is given twice; each file must name another lab", file, name));
    auto member = std::make_unique<Member>();
    member->session = std::make_unique<LabSession>(std::move(config), directory / name);
    member->public_bus = std::make_unique<hal::Bus>("memq://");
    member->session->join(*member->public_bus);
    labs_.push_back(std::move(member));
  }
  for (const auto& member : labs_)
    if (member->session->config().labs.size() != labs_.size())
      throw hal::ConfigError(fmt::format("shared.labs of {} names {} labs, but {} were given",
                                         member->session->config().lab, member->session->config().labs.size(),
                                         labs_.size()));
  for (const auto& member : labs_) start_gateway(member->session->config().lab);
}

JointRun::~JointRun() = default;

JointRun::Member& JointRun::member(const std::string& name) {
  for (const auto& m : labs_)
    if (m->session->config().lab == name) return *m;
  throw std::out_of_range("no lab " + name);
}

LabSession& JointRun::lab(const std::string& name) {
  return *member(name).session;
}

void JointRun::kill_gateway(const std::string& lab) {
  member(lab).gateway.reset();
}

void JointRun::start_gateway(const std::string& lab) {
  Member& m = member(lab);
  std::vector<std::unique_ptr<gateway::Link>> links;
  for (const std::string& peer : m.session->config().labs)
    if (peer != lab) links.push_back(network_.end(lab, peer));
  m.gateway =
      std::make_unique<gateway::Gateway>(*m.public_bus, lab, ++boots_, m.session->gateway().exports, std::move(links));
}

bool JointRun::step() {
  const std::chrono::microseconds now = step_time * steps_;
  if (turn_ == 0) advanced_ = going_ = false;
  for (; turn_ < labs_.size(); ++turn_) {
    Member& m = *labs_[turn_];
    const auto step = m.session->run().step(now);
    // the others stand still meanwhile, so that the course does not depend on how long it takes
    if (m.session->run().awaits_arena()) {
      hal::wait_for_service(m.session->arena());
      return true;
    }
    advanced_ = advanced_ || step == lab::LabRun::Step::advanced;
    going_ = going_ || step != lab::LabRun::Step::ended;
    m.public_bus->drain();
    if (m.gateway) m.gateway->tick(now);
  }
  turn_ = 0;
  ++steps_;
  network_.step();
  // While a link is down waiting is right, however long.
  idle_steps_ = advanced_ || !links_up() ? 0 : idle_steps_ + 1;
  if (idle_steps_ > deadlock_steps)
    for (const auto& m : labs_) m->session->run().stop("the labs wait for each other and no link is down");
  return going_;
}

bool JointRun::links_up() const {
  return std::all_of(labs_.begin(), labs_.end(), [](const auto& m) {
    return m->gateway && std::all_of(m->gateway->links().begin(), m->gateway->links().end(),
                                     [](const auto& l) { return l->stats().up; });
  });
}

bool JointRun::finished() const {
  return std::all_of(labs_.begin(), labs_.end(), [](const auto& m) { return m->session->run().finished(); });
}

std::vector<nlohmann::json> JointRun::results(double wall_s) const {
  std::vector<nlohmann::json> results;
  for (const auto& m : labs_) {
    std::map<std::string, lab::Traffic> traffic;
    if (m->gateway)
      for (const auto& link : m->gateway->links()) {
        const gateway::LinkStats stats = link->stats();
        lab::Traffic& t = traffic[link->peer()] = {stats.received_messages, stats.received_bytes, stats.counters.all()};
        t.counters["sent_messages"] = stats.sent_messages;
        t.counters["sent_bytes"] = stats.sent_bytes;
      }
    results.push_back(lab::lab_result(m->session->run(), {.computing_s = wall_s, .waiting_s = 0}, traffic));
  }
  return results;
}

}  // namespace arkmesh::app
