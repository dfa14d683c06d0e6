#include "app/joint_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <map>
#include <stdexcept>

#include "hal/arenas/robot_words.hpp"
#include "hal/counted.hpp"
#include "hal/files/replace_file.hpp"
#include "hal/record/result_file.hpp"
#include "lab/result.hpp"

namespace arkmesh::app {
namespace {

using Clock = std::chrono::steady_clock;
using hal::TimePoint;

constexpr std::chrono::microseconds step_time{1000};
constexpr std::chrono::milliseconds wait_at_most{20};  // for arenas that keep real time, in one step
constexpr std::uint64_t deadlock_steps = 10'000;       // repetition and dead-peer rules have long had their say by then
constexpr std::uint64_t look_steps = 50;  // a divisor; asking all links takes longer than a step that does nothing
constexpr std::uint64_t show_steps = 64;
constexpr std::chrono::milliseconds serve_viewers_each{2};
constexpr std::chrono::milliseconds scenario_wait{10};  // for one that computes elsewhere; then viewers are served
constexpr int scenario_waits = 2;
constexpr std::uint64_t serve_steps = 256;  // an arena that shows something is waited for, and is served then

std::map<std::string, lab::Traffic> traffic_of(const gateway::Gateway* gateway) {
  std::map<std::string, lab::Traffic> by_peer;
  if (!gateway) return by_peer;
  for (const auto& link : gateway->links()) {
    const gateway::LinkStats stats = link->stats();
    lab::Traffic& t = by_peer[link->peer()] = {stats.peer_version, stats.received_messages, stats.received_bytes,
                                               stats.counters.all()};
    t.counters["sent_messages"] = stats.sent_messages;
    t.counters["sent_bytes"] = stats.sent_bytes;
  }
  return by_peer;
}

// A row per period with every lab's hash, so that the first difference between two runs is found at once. Returns
// errno.
int join_hashes(const std::vector<const ConfiguredLab*>& labs, const std::filesystem::path& directory) {
  std::string out = "period";
  std::vector<std::ifstream> in;
  for (const ConfiguredLab* lab : labs) {
    out += ',' + lab->name();
    in.emplace_back(lab->folder().directory() / "hash.csv");
    std::string header;
    std::getline(in.back(), header);
  }
  out += '\n';
  for (std::string row, other; !in.empty() && std::getline(in.front(), row);) {
    for (std::size_t i = 1; i < in.size(); ++i) row += std::getline(in[i], other) ? other.substr(other.find(',')) : ",";
    out += row + '\n';
  }
  return hal::replace_file(directory / "hash.csv", out);
}

}  // namespace

JointRun::JointRun(std::vector<hal::Config> configs, const std::filesystem::path& directory, Folder use,
                   const std::map<std::string, OwnParts*, std::less<>>& own, bool page)
    : directory_(directory), network_(1) {
  for (hal::Config& config : configs) {
    const std::string name = config.root().section("lab").get("name", std::string(), {.required = true});
    const std::string file = config.file().string();
    if (std::any_of(labs_.begin(), labs_.end(), [&](const auto& m) { return m->lab.name() == name; }))
      throw hal::ConfigError(fmt::format("{}: lab '{}' is given twice; each file must name another lab", file, name));
    const auto parts = own.find(name);
    auto member = std::make_unique<Member>(std::move(config), directory / name, loop_,
                                           parts == own.end() ? nullptr : parts->second);
    labs_.push_back(std::move(member));
  }
  for (const auto& member : labs_)
    if (member->lab.config().labs.size() != labs_.size())
      throw hal::ConfigError(fmt::format("shared.labs of {} names {}, but {} were given", member->lab.name(),
                                         hal::counted(member->lab.config().labs.size(), "lab"), labs_.size()));
  if (page) {
    std::vector<ConfiguredLab*> all;
    for (const auto& member : labs_) all.push_back(&member->lab);
    page_ = LiveView::make(loop_, all, directory.string());
  }
  if (use == Folder::of_batch)
    std::filesystem::create_directories(directory);
  else
    lab::claim_run_folder(directory, use == Folder::moved_aside);
  const auto worlds = labs_.size() > 1 ? std::make_shared<lab::WorldReader>() : nullptr;
  for (const auto& member : labs_) {
    member->lab.open_run(worlds);
    member->membership.emplace(member->lab, member->lab.bus());
  }
  if (page_) page_->count();
  nlohmann::json running = labs_.front()->lab.facts();
  running.erase("lab");
  if (const int error = hal::save_running(directory / "result.json", std::move(running)); error != 0)
    throw std::runtime_error(
        fmt::format("{} cannot be written: {}; make room there, or choose another directory with --out",
                    (directory / "result.json").string(), std::strerror(error)));
  for (const auto& member : labs_) start_gateway(member->lab.name());
}

JointRun::~JointRun() = default;

JointRun::Member& JointRun::member(const std::string& name) {
  for (const auto& m : labs_)
    if (m->lab.name() == name) return *m;
  throw std::out_of_range("no lab " + name);
}

ConfiguredLab& JointRun::lab(const std::string& name) {
  return member(name).lab;
}

void JointRun::kill_gateway(const std::string& lab) {
  member(lab).gateway.reset();
}

void JointRun::start_gateway(const std::string& lab) {
  Member& m = member(lab);
  std::vector<std::unique_ptr<gateway::Link>> links;
  for (const std::string& peer : m.lab.config().labs)
    if (peer != lab) links.push_back(network_.end(lab, peer));
  m.gateway = std::make_unique<gateway::Gateway>(m.lab.bus(), lab, ++boots_, m.lab.gateway().rules, std::move(links));
  m.gateway->start();
}

bool JointRun::step() {
  const std::chrono::microseconds now = step_time * steps_ + waited_;
  if (turn_ == 0) {
    advanced_ = going_ = false;
    wake_ = TimePoint::max();
  }
  for (; turn_ < labs_.size(); ++turn_) {
    Member& m = *labs_[turn_];
    if (goes_last(m)) {
      going_ = true;
      exchange(m, now);
      continue;
    }
    step(m, now);
    if (m.awaits_scenario) continue;
    if (m.lab.runner().awaits_arena()) {
      const TimePoint wanted = m.lab.arena().next_service();
      // One that computes its own time: the others stand still meanwhile, so that the course does not depend on how
      // long it takes.
      if (wanted == TimePoint::min()) {
        time_.serve();
        return true;
      }
      wake_ = std::min(wake_, wanted);
    }
    exchange(m, now);
  }
  if (!settle_scenarios(now)) return true;
  if (std::ranges::all_of(labs_, [](const auto& m) { return m->lab.runner().complete(); }))
    for (const auto& m : labs_) m->lab.runner().leave_complete();
  turn_ = 0;
  ++steps_;
  network_.step();
  if (steps_ % serve_steps == 0 || viewers_wait()) time_.serve();
  const bool real_time = wake_ != TimePoint::max();
  if (real_time && !advanced_) wait_for_arenas();
  // While a link is down waiting is right, however long.
  idle_steps_ = advanced_ || real_time ? 0 : idle_steps_ + 1;
  if (idle_steps_ > 0 && idle_steps_ % look_steps == 0 && !links_up()) idle_steps_ = 0;
  if (idle_steps_ >= deadlock_steps)
    for (const auto& m : labs_) m->lab.runner().fail("the labs are waiting for each other although no link is down");
  return going_;
}

void JointRun::step(Member& m, std::chrono::microseconds now) {
  const auto step = m.lab.runner().step(now);
  m.went_on = step == lab::Runner::Step::advanced;
  m.awaits_scenario = m.lab.runner().awaits_scenario();
  advanced_ = advanced_ || m.went_on;
  going_ = going_ || step != lab::Runner::Step::ended;
}

// The second half of the turns of labs whose scenarios compute elsewhere, all at the same time, so that the course does
// not depend on how long they take. False: one takes so long that others want to be served.
bool JointRun::settle_scenarios(std::chrono::microseconds now) {
  for (const auto& m : labs_) {
    for (int waits = 0; m->awaits_scenario; ++waits) {
      if (waits == scenario_waits) {
        time_.serve();
        return false;
      }
      m->lab.runner().await_scenario(scenario_wait);
      step(*m, now);
      if (!m->awaits_scenario) exchange(*m, now);
    }
  }
  return true;
}

void JointRun::exchange(Member& m, std::chrono::microseconds now) {
  if (m.gateway) m.gateway->tick(now);
}

// A lab that can wait computes ahead of one that keeps time, and has told its state when that comes to the boundary: so
// it is where each has a process of its own. Whose arena must be served is never kept from it.
bool JointRun::goes_last(const Member& m) const {
  const hal::Arena& arena = m.lab.arena();
  if (arena.info().can_wait || arena.next_service() != TimePoint::max()) return false;
  return std::ranges::any_of(labs_,
                             [](const auto& other) { return other->lab.arena().info().can_wait && other->went_on; });
}

bool JointRun::viewers_wait() {
  if (!page_) return false;
  const TimePoint now = time_.now();
  if (now - served_ < serve_viewers_each) return false;
  served_ = now;
  return true;
}

// Arenas that keep real time: what is waited for them passes for all labs, which tell each other how they are.
void JointRun::wait_for_arenas() {
  const TimePoint before = time_.now();
  time_.wait_until(std::min(wake_, before + wait_at_most));
  waited_ += std::chrono::duration_cast<std::chrono::microseconds>(time_.now() - before);
}

bool JointRun::links_up() const {
  return std::all_of(labs_.begin(), labs_.end(), [](const auto& m) {
    return m->gateway && std::all_of(m->gateway->links().begin(), m->gateway->links().end(),
                                     [](const auto& l) { return l->stats().up; });
  });
}

bool JointRun::finished() const {
  return std::all_of(labs_.begin(), labs_.end(), [](const auto& m) { return m->lab.runner().finished(); });
}

bool JointRun::robots_stand() const {
  return std::ranges::all_of(labs_, [](const auto& m) { return m->lab.runner().robots_stand(); });
}

std::string JointRun::not_standing() const {
  std::string out;
  for (const auto& m : labs_)
    if (const std::string robots = hal::in_words(m->lab.runner().not_standing()); !robots.empty())
      out += fmt::format("{}{}: {}", out.empty() ? "" : "; ", m->lab.name(), robots);
  return out;
}

std::string JointRun::names() const {
  std::vector<std::string> names;
  for (const auto& m : labs_) names.push_back(m->lab.name());
  return fmt::format("{}", fmt::join(names, "+"));
}

nlohmann::json JointRun::run(hal::StopRequest& stop, hal::Progress* progress) {
  const lab::Runner& first = lab(0).runner();
  const double period_s = static_cast<double>(lab(0).config().period.count()) * 1e-6;
  const auto begun = Clock::now();
  while (step()) {
    if (stop.stopped())
      for (const auto& m : labs_) m->lab.runner().stop("stopped by the operator");
    if (progress && (steps_ % show_steps == 0 || first.awaits_arena()))
      progress->show(first.period(), first.last_period(), period_s,
                     first.awaits_arena() ? first.state_text() : "running");
  }
  if (progress) progress->done();
  const double wall_s = std::chrono::duration<double>(Clock::now() - begun).count();
  if (page_) page_->finish(time_);
  return save(wall_s);
}

nlohmann::json JointRun::save(double wall_s) const {
  std::vector<nlohmann::json> results;
  std::vector<const ConfiguredLab*> labs;
  for (const auto& m : labs_) {
    results.push_back(lab::lab_result(m->lab.facts(), m->lab.runner(), {.computing_s = wall_s, .waiting_s = 0},
                                      traffic_of(m->gateway.get())));
    m->lab.folder().save_result(results.back());
    labs.push_back(&m->lab);
  }
  nlohmann::json result = lab::joint_result(results);
  result["wall"] = {{"total_s", wall_s}, {"speed", wall_s > 0 ? result.at("duration_s").get<double>() / wall_s : 0}};
  if (const int error = join_hashes(labs, directory_); error != 0 && hal::outcome_in(result) == hal::Outcome::finished)
    hal::set_outcome(result, hal::Outcome::failed, fmt::format("hash.csv cannot be written: {}", std::strerror(error)));
  hal::save_json(directory_ / "result.json", result);
  return result;
}

}  // namespace arkmesh::app
