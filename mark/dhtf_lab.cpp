#include "mark/dhtf_lab.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "scenarios/dhtf/fields.hpp"
#include "scenarios/dhtf/sites.hpp"

namespace arkmesh::mark {
namespace {

namespace dhtf = scenarios::dhtf;
using Levels = std::vector<std::int64_t>;

constexpr double same_place_m = 1e-3;

// Neither poses nor how many robots are in a team; what the labs have agreed on is our own file's.
void tell_unknown(lab::Lab& lab) {
  using lab::Unknown;
  lab.publish(lab::unknown_rule().name, lab::unknown_values({Unknown::poses, Unknown::headings, Unknown::ids,
                                                             Unknown::counts, Unknown::settings, Unknown::periods}));
}

std::vector<int> to_ints(const Levels& values) {
  return {values.begin(), values.end()};
}

Levels needed_by(const dhtf::Settings& settings, const std::string& lab, const std::vector<int>& hard) {
  const Levels& requirement = settings.requirements.find(lab)->second;
  Levels needed;
  for (const int h : hard) needed.push_back(requirement[h ? 1 : 0]);
  return needed;
}

// Throws when the shared world's sites are not where the original has them.
void check_places(const lab::Lab& lab, const std::vector<int>& cells) {
  const auto& x_um = lab.initial_field(lab.owner(), "site_x_um");
  const auto& y_um = lab.initial_field(lab.owner(), "site_y_um");
  const auto& arena_um = lab.initial_field(lab.owner(), lab::arena_rule().name);
  const double side_m = lab.arena().width_m, scale = lab.projection().scale;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const hal::Pose here = dhtf::cell_in_shared(cells[i], side_m, side_m, lab.projection());
    const double x_m = static_cast<double>(x_um[i]) * 1e-6, y_m = static_cast<double>(y_um[i]) * 1e-6;
    if (std::hypot(x_m - here.x_m, y_m - here.y_m) <= same_place_m) continue;
    throw std::runtime_error(
        fmt::format("site {} (cell {}) has different places in the shared world: {:.3f}, {:.3f} m for {}, whose arena "
                    "is {} m wide at scale {}, but {:.3f}, {:.3f} m for the original, whose arena (mark.side_m) is {} "
                    "m wide at scale {}; set shared.projection.{}.scale = {}",
                    i, cells[i], x_m, y_m, lab.owner(), static_cast<double>(arena_um.at(0)) * 1e-6,
                    lab.projection(lab.owner()).scale, here.x_m, here.y_m, side_m, scale, lab.name(),
                    lab.projection(lab.owner()).scale * static_cast<double>(arena_um.at(0)) * 1e-6 / side_m));
  }
}

}  // namespace

// ---------------------------------------------------------------- the original is the client

DhtfClientLab::DhtfClientLab(dhtf::Settings settings, DhtfServerConversation& talk)
    : settings_(std::move(settings)), talk_(talk), team_(static_cast<std::size_t>(settings_.sites), 0) {}

void DhtfClientLab::begin(lab::Lab& lab) {
  dhtf::declare_fields(lab, settings_);
  tell_unknown(lab);
  lab.publish("team", team_);
  lab.total("completed", 0);
}

// The owner's sites, as Init tells them: its types are ours, and of all others those that somebody finds hard.
void DhtfClientLab::meet(lab::Lab& lab) {
  Init init{.cells = to_ints(lab.initial_field(lab.owner(), "site_cell")), .server_hard = {}, .client_hard = {}};
  const auto sites = static_cast<std::size_t>(settings_.sites);
  init.server_hard.assign(sites, 0);
  bool complete = init.cells.size() == sites;
  for (const std::string& each : lab.labs()) {
    const Levels& hard = lab.initial_field(lab.owner(), dhtf::hard_field(each));
    complete = complete && hard.size() == sites;
    if (!complete) break;
    if (each == lab.name()) init.client_hard = to_ints(hard);
    for (std::size_t i = 0; i < sites && each != lab.name(); ++i) init.server_hard[i] |= static_cast<int>(hard[i]);
  }
  complete = complete && lab.initial_field(lab.owner(), "site_x_um").size() == sites &&
             lab.initial_field(lab.owner(), "site_y_um").size() == sites && read_init(to_text(init)).has_value();
  if (!complete)
    throw std::runtime_error(fmt::format(
        "{} publishes no sites that the original can read; is its scenario that of shared.owner?", lab.owner()));
  check_places(lab, init.cells);
  needed_ = needed_by(settings_, lab.name(), init.client_hard);
  talk_.set_init(std::move(init));
}

void DhtfClientLab::on_period(lab::Lab& lab) {
  if (needed_.empty()) meet(lab);
  const Levels &active = lab.field(lab.owner(), "active"), &executed = lab.field(lab.owner(), "executed");
  if (active.size() != needed_.size() || executed.size() != needed_.size()) return;
  std::vector<int> inactive;
  for (const std::int64_t one : active) inactive.push_back(one == 0);
  talk_.set_inactive(std::move(inactive));
  std::int64_t all = 0;
  for (const std::int64_t one : executed) all += one;
  lab.total("completed", static_cast<std::uint64_t>(all));
}

void DhtfClientLab::on_poses(lab::Lab& lab, const hal::PoseFrame&) {
  if (needed_.empty()) return;
  const Levels& active = lab.field(lab.owner(), "active");
  Levels team(needed_.size(), 0);
  for (std::size_t i = 0; i < std::min(team.size(), active.size()); ++i)
    if (active[i] == 1 && talk_.ready()[i] == 1) team[i] = needed_[i];
  if (team == team_) return;
  team_ = team;
  lab.publish("team", std::move(team));
}

// ---------------------------------------------------------------- the original is the server

DhtfServerLab::DhtfServerLab(dhtf::Settings settings, DhtfClientConversation& talk)
    : settings_(std::move(settings)), talk_(talk) {}

void DhtfServerLab::begin(lab::Lab& lab) {
  dhtf::declare_fields(lab, settings_);
  tell_unknown(lab);
  lab.publish("team", Levels(static_cast<std::size_t>(settings_.sites), 0));
  lab.total("completed", 0);
}

void DhtfServerLab::publish_sites(lab::Lab& lab) {
  talk_.keep();
  const Init& init = *talk_.init();
  Levels cells, x_um, y_um;
  for (const int cell : init.cells) {
    const hal::Pose p = dhtf::cell_in_shared(cell, lab.arena().width_m, lab.arena().height_m, lab.projection());
    cells.push_back(cell);
    x_um.push_back(std::llround(p.x_m * 1e6));
    y_um.push_back(std::llround(p.y_m * 1e6));
  }
  lab.publish("site_cell", cells);
  lab.publish("site_x_um", x_um);
  lab.publish("site_y_um", y_um);
  // It knows two labs: itself, and another one, which all others are to it.
  for (const std::string& each : lab.labs()) {
    const std::vector<int>& hard = each == lab.name() ? init.server_hard : init.client_hard;
    lab.publish(dhtf::hard_field(each), {hard.begin(), hard.end()});
    needed_.push_back(needed_by(settings_, each, hard));
  }
  teams_.resize(lab.labs().size());
  heard_.resize(lab.labs().size(), 0);
  executed_by_.assign(lab.labs().size() * cells.size(), 0);
}

void DhtfServerLab::on_poses(lab::Lab& lab, const hal::PoseFrame&) {
  if (needed_.empty() && talk_.init()) publish_sites(lab);
  if (!needed_.empty()) publish_levels(lab);
}

// What it has judged, with the teams that this lab knew of then.
void DhtfServerLab::publish_levels(lab::Lab& lab) {
  const std::size_t sites = talk_.inactive().size();
  Levels active;
  for (const int one : talk_.inactive()) active.push_back(one == 0);
  executed_.resize(sites, 0);
  for (std::size_t i = 0; i < sites; ++i) {
    if (talk_.executed()[i] == executed_[i]) continue;
    executed_[i] = talk_.executed()[i];
    for (std::size_t l = 0; l < teams_.size(); ++l)
      executed_by_[l * sites + i] = lab.labs()[l] == lab.name() || teams_[l].empty() ? needed_[l][i] : teams_[l][i];
  }
  lab.publish("active", std::move(active));
  lab.publish("executed", executed_);
  lab.publish("executed_by", executed_by_);
}

void DhtfServerLab::on_period(lab::Lab& lab) {
  if (needed_.empty()) return;
  talk_.go();
  const Levels& active = lab.field(lab.name(), "active");
  std::vector<int> ready(active.begin(), active.end());
  for (std::size_t l = 0; l < needed_.size(); ++l) {
    const std::string& each = lab.labs()[l];
    if (each == lab.name()) continue;
    // A lab whose state has not advanced may be cut off: its old team is no evidence.
    const bool is_heard = lab.state(each).period > std::exchange(heard_[l], lab.state(each).period);
    teams_[l] = is_heard ? lab.field(each, "team") : Levels{};
    for (std::size_t i = 0; i < ready.size(); ++i)
      ready[i] = ready[i] && i < teams_[l].size() && teams_[l][i] >= needed_[l][i];
  }
  talk_.set_ready(std::move(ready));
  std::int64_t all = 0;
  for (const std::int64_t one : lab.field(lab.name(), "executed")) all += one;
  lab.total("completed", static_cast<std::uint64_t>(all));
}

}  // namespace arkmesh::mark
