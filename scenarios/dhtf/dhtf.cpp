#include "scenarios/dhtf/dhtf.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "hal/fixed_math.hpp"
#include "scenarios/dhtf/controller/dhtf_messages.h"
#include "scenarios/dhtf/fields.hpp"
#include "scenarios/dhtf/robot_messages.hpp"
#include "scenarios/dhtf/sites.hpp"
#include "scenarios/kit/bearing.hpp"
#include "scenarios/wall_sensor.hpp"

namespace arkmesh::scenarios::dhtf {
namespace {

constexpr std::int64_t most_rows = 100;  // of completed.csv for one site at one boundary

std::string completed_header(const lab::Lab& lab) {
  std::string header = "period,time_s,site,cell,active_since_s";
  for (const char* what : {"hard", "team"})
    for (const std::string& each : lab.labs()) header += fmt::format(",{}.{}", what, each);
  return header;
}

double seconds(hal::LabTime t) {
  return static_cast<double>(t.count()) * 1e-6;
}

// In words what draw_sites() draws, and what robots' LEDs say.
void explain_sites(lab::Lab& lab) {
  const bool few = lab.labs().size() <= 4;
  const std::string teams = fmt::format("task, robots at it / needed in {}",
                                        few ? fmt::format("{}", fmt::join(lab.labs(), " + ")) : "each lab");
  lab.show({.of = "series.completed", .words = "completed tasks", .curve = true});
  lab.show({.of = "colour.site_active", .words = "easy " + teams});
  lab.show({.of = "colour.site_hard", .words = "hard " + teams});
  lab.show({.of = "colour.site_idle", .words = "site without a task, and when it has one again"});
  lab.show({.of = "colour.own", .words = "a robot that the task needs here; filled: it is there"});
  lab.show({.of = "colour.other", .words = "the same in another lab"});
  lab.show({.of = "led.4", .words = "walking"});
  lab.show({.of = "led.2", .words = "dwelling at a task"});
  lab.show({.of = "led.1", .words = "leaving"});
}

}  // namespace

Dhtf::Dhtf(Settings settings) : settings_(std::move(settings)), team_(static_cast<std::size_t>(settings_.sites), 0) {}

void Dhtf::begin(lab::Lab& lab) {
  declare_fields(lab, settings_);
  lab.publish("team", team_);
  lab.total("completed", 0);
  explain_sites(lab);
  if (lab.is_owner()) decide_sites(lab);
}

void Dhtf::decide_sites(lab::Lab& lab) {
  // Places: cells of the owner's arena, in the shared frame.
  hal::RandomStream& random = lab.random("sites");
  std::vector<std::int64_t> cells, x_um, y_um;
  for (int cell : draw_cells(settings_, random)) {
    const hal::Pose p = cell_in_shared(cell, lab.arena().width_m, lab.arena().height_m, lab.projection());
    const double nudge_m = cells.empty() ? settings_.nudge_site_m : 0;
    cells.push_back(cell);
    x_um.push_back(std::llround((p.x_m + nudge_m) * 1e6));
    y_um.push_back(std::llround(p.y_m * 1e6));
  }
  lab.publish("site_cell", cells);
  lab.publish("site_x_um", x_um);
  lab.publish("site_y_um", y_um);
  // Types, and what they mean for the teams.
  std::vector<std::vector<std::int64_t>> needed;
  for (const std::string& each : lab.labs()) {
    const std::vector<int> hard = draw_hard(settings_, random);
    lab.publish(hard_field(each), {hard.begin(), hard.end()});
    const std::vector<std::int64_t>& requirement = settings_.requirements.find(each)->second;
    auto& row = needed.emplace_back();
    for (int h : hard) row.push_back(static_cast<int>(requirement[h ? 1 : 0]));
  }
  coordinator_.emplace(std::move(needed), settings_.respawn);
  lab.publish("active", coordinator_->active());
  lab.publish("executed", coordinator_->executed());
  lab.publish("executed_by", coordinator_->executed_by());
}

void Dhtf::place_sites(lab::Lab& lab) {
  const auto sites = static_cast<std::size_t>(settings_.sites);
  const auto& cells = lab.initial_field(lab.owner(), "site_cell");
  const auto& x_um = lab.initial_field(lab.owner(), "site_x_um");
  const auto& y_um = lab.initial_field(lab.owner(), "site_y_um");
  bool complete = cells.size() == sites && x_um.size() == sites && y_um.size() == sites;
  for (const std::string& each : lab.labs())
    complete = complete && lab.initial_field(lab.owner(), hard_field(each)).size() == sites;
  // An owner that said nothing usable about its sites: there are none.
  if (!complete) {
    lab.counts().add("sites.missing");
    return;
  }
  sites_.resize(sites);
  for (std::size_t i = 0; i < sites; ++i) {
    Site& site = sites_[i];
    site.cell = cells[i];
    site.in_shared = {.x_m = static_cast<double>(x_um[i]) * 1e-6, .y_m = static_cast<double>(y_um[i]) * 1e-6};
    std::size_t hard = 0;
    for (const std::string& each : lab.labs()) {
      site.hard.push_back(lab.initial_field(lab.owner(), hard_field(each))[i]);
      hard += static_cast<std::size_t>(site.hard.back());
    }
    site.timeout_s = timeout_s(settings_, hard, lab.labs().size());
  }
}

const Dhtf::Site* Dhtf::site_at(const hal::Pose& p) const {
  const double reach_m2 = settings_.site_radius_m * settings_.site_radius_m;
  for (const Site& site : sites_)
    if (kit::distance2_m2(p, site.in_shared) < reach_m2) return &site;
  return nullptr;
}

void Dhtf::on_poses(lab::Lab& lab, const hal::PoseFrame& frame) {
  if (sites_.empty()) return;
  std::vector<std::int64_t> team(sites_.size(), 0);
  for (const hal::Observation& seen : frame.robots) {
    const Site* site = site_at(lab.projection().to_shared(seen.pose));
    // A team is made of robots that show that they dwell. An inactive site has none.
    if (site && site->active && seen.led == dwelling) ++team[static_cast<std::size_t>(site - sites_.data())];
    const Place place{
        .in_site = site != nullptr,
        .active = site && site->active,
        .timeout_s = site ? site->timeout_s : 0,
        .wall_sectors = blocked_sectors(seen.pose, lab.arena().width_m, lab.arena().height_m, settings_.wall_zone_m)};
    const Told told = message_for(place, seen.led);
    lab.tell({.robot = seen.robot, .slot = DHTF_SLOT, .kind = told.kind, .value = told.value}, told.shown,
             settings_.repeat);
  }
  if (team == team_) return;
  team_ = team;
  lab.publish("team", std::move(team));
}

// Takes over what the owner's merged state says: activity, and executed tasks.
void Dhtf::take_snapshot(lab::Lab& lab) {
  const auto& active = lab.field(lab.owner(), "active");
  const auto& executed = lab.field(lab.owner(), "executed");
  const auto& executed_by = lab.field(lab.owner(), "executed_by");
  const std::size_t sites = sites_.size(), labs = lab.labs().size();
  if (active.size() != sites || executed.size() != sites || executed_by.size() != sites * labs) return;
  std::int64_t total = 0;
  for (std::size_t i = 0; i < sites; ++i) {
    Site& site = sites_[i];
    // Rows and total heal states that never came: of several executions at once, all have the newest's teams. No owner
    // can fill the disk.
    for (std::int64_t n = std::max(site.executed, executed[i] - most_rows); n < executed[i]; ++n) {
      std::string row = fmt::format("{},{:.6f},{},{},{:.6f}", lab.period(), seconds(lab.now()), i, site.cell,
                                    seconds(site.active_since));
      for (std::int64_t hard : site.hard) row += fmt::format(",{}", hard);
      for (std::size_t l = 0; l < labs; ++l) row += fmt::format(",{}", executed_by[l * sites + i]);
      lab.row("completed", completed_header(lab), row);
    }
    site.executed = executed[i];
    total += executed[i];
    if (!site.active && active[i] == 1) site.active_since = lab.now();
    if (site.active && active[i] != 1) site.idle_since = lab.now();
    site.active = active[i] == 1;
  }
  lab.total("completed", static_cast<std::uint64_t>(total));
}

// Robots of that lab that a task at this site asks for.
std::int64_t Dhtf::needed_at(const Site& site, const lab::Lab& lab, std::size_t of) const {
  return settings_.requirements.find(lab.labs()[of])->second[site.hard[of] ? 1 : 0];
}

// A dot for each robot that a lab's team needs, below the site: filled for each robot that is there. The own lab's ring
// is the inner one.
void Dhtf::draw_team(lab::Lab& lab, const Site& site, int ring, const std::string& of, std::int64_t team,
                     std::int64_t needed) const {
  constexpr std::int64_t most = 12;  // more cannot be counted at a glance; the label has the numbers
  constexpr double widest_rad = 0.5;
  if (needed > most) return;
  const double radius_m = settings_.site_radius_m / lab.projection().scale;
  const hal::Pose centre = lab.projection().to_arena(site.in_shared);
  const double step_rad =
      std::min(widest_rad, std::numbers::pi / static_cast<double>(std::max<std::int64_t>(needed, 1)));
  for (std::int64_t i = 0; i < needed; ++i) {
    const double angle =
        -std::numbers::pi / 2 + (static_cast<double>(i) - 0.5 * static_cast<double>(needed - 1)) * step_rad;
    const double from_centre_m = radius_m * (1.2 + 0.3 * ring);
    lab.draw(hal::Circle{.at = {centre.x_m + from_centre_m * hal::fixed::cos(angle),
                                centre.y_m + from_centre_m * hal::fixed::sin(angle)},
                         .radius_m = 0.1 * radius_m,
                         .colour = of == lab.name() ? hal::Colour::own : hal::Colour::other,
                         .filled = i < team});
  }
}

// Every site with the teams that all labs merged, as `there/needed` in lab order, or with the time until it is back.
void Dhtf::draw_sites(lab::Lab& lab) const {
  const std::vector<std::string>& labs = lab.labs();
  const auto own = static_cast<std::size_t>(std::find(labs.begin(), labs.end(), lab.name()) - labs.begin());
  for (std::size_t i = 0; i < sites_.size(); ++i) {
    const Site& site = sites_[i];
    const hal::Pose centre = lab.projection().to_arena(site.in_shared);
    hal::Circle circle{.at = {centre.x_m, centre.y_m}, .radius_m = settings_.site_radius_m / lab.projection().scale};
    if (!site.active) {
      const hal::LabTime left = std::max(hal::LabTime{0}, site.idle_since + settings_.respawn - lab.now());
      circle.colour = hal::Colour::site_idle;
      circle.dashed = true;
      circle.label = fmt::format("back in {:.0f} s", std::ceil(seconds(left)));
      lab.draw(std::move(circle));
      continue;
    }
    std::string teams;
    int ring = 0;
    for (std::size_t l = 0; l < labs.size(); ++l) {
      const auto& field = lab.field(labs[l], "team");
      const std::int64_t team = i < field.size() ? field[i] : 0, needed = needed_at(site, lab, l);
      teams += fmt::format("{}{}/{}", teams.empty() ? "" : " + ", team, needed);
      draw_team(lab, site, l == own ? 0 : ++ring, labs[l], team, needed);
    }
    circle.colour = site.hard[own] ? hal::Colour::site_hard : hal::Colour::site_active;
    circle.filled = true;
    circle.label = fmt::format("{} {}", site.hard[own] ? "hard" : "easy", teams);
    lab.draw(std::move(circle));
  }
}

void Dhtf::on_period(lab::Lab& lab) {
  if (lab.period() == 0) place_sites(lab);
  if (sites_.empty()) return;
  take_snapshot(lab);
  draw_sites(lab);
  if (!coordinator_) return;
  // The owner judges what all labs merged; its decisions are in force from when its next state is merged.
  std::vector<std::vector<std::int64_t>> teams;
  heard_.resize(lab.labs().size(), 0);
  for (std::size_t l = 0; l < heard_.size(); ++l) {
    const std::string& each = lab.labs()[l];
    // A lab whose state has not advanced since the last boundary may be cut off: its old team is no evidence.
    const bool is_heard = lab.state(each).period > heard_[l];
    teams.push_back(is_heard ? lab.field(each, "team") : std::vector<std::int64_t>{});
    heard_[l] = lab.state(each).period;
  }
  if (!coordinator_->update(lab.now(), teams, lab.field(lab.owner(), "active"))) return;
  lab.publish("active", coordinator_->active());
  lab.publish("executed", coordinator_->executed());
  lab.publish("executed_by", coordinator_->executed_by());
}

bool Dhtf::finished(const lab::Lab&) const {
  return false;
}

}  // namespace arkmesh::scenarios::dhtf
