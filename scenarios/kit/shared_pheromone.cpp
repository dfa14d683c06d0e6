#include "scenarios/kit/shared_pheromone.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

namespace arkmesh::scenarios::kit {
namespace {

// A cell and what was laid in it, as one number.
constexpr int amount_bits = 31;
constexpr std::int64_t most_told = (std::int64_t{1} << amount_bits) - 1;

std::int64_t packed(int cell, std::int64_t amount) {
  return std::int64_t{cell} << amount_bits | amount;
}

}  // namespace

SharedPheromone::SharedPheromone(std::string name, const Pheromone::Settings& settings)
    : name_(std::move(name)), field_name_("kit." + name_), field_(settings) {}

void SharedPheromone::begin(lab::Lab& lab) const {
  lab.declare({.name = field_name_,
               .length = most_cells,
               .low = 0,
               .high = packed(static_cast<int>(field_.cells().size()), 0) - 1,
               .up_to = true});
  lab.publish(field_name_, {});
}

void SharedPheromone::lay(lab::Lab& lab, const hal::Pose& in_arena, double amount) {
  const hal::Pose at = in_field(lab, in_arena);
  const int cell = field_.cell_at({at.x_m, at.y_m});
  if (cell < 0) return;
  const bool is_amount = amount >= least_amount && amount <= most_amount;
  if (!is_amount || (laid_.size() == most_cells && !laid_.contains(cell)))
    return lab.counts().add("kit." + name_ + ".not_laid");
  std::int64_t& here = laid_[cell];
  here = std::min<std::int64_t>(most_told, here + std::llround(amount * 1000));
}

void SharedPheromone::tell(lab::Lab& lab) const {
  std::vector<std::int64_t> told;
  told.reserve(laid_.size());
  for (const auto& [cell, amount] : laid_) told.push_back(packed(cell, amount));
  lab.publish(field_name_, std::move(told));
}

void SharedPheromone::on_period(lab::Lab& lab) {
  for (const std::string& each : lab.labs()) {
    if (lab.state(each).made_at)
      throw std::runtime_error(
          fmt::format("the pheromone {} needs all of each state, and {} tells it by events or more rarely than each "
                      "period; leave out gate.exchange and the periods of its states",
                      name_, each));
    const std::uint32_t period = lab.state(each).period;
    const auto before = told_.find(each);
    if (before != told_.end() && period == before->second) continue;  // nothing new of it
    if (before != told_.end() && period > before->second + 1)
      lab.counts().add("kit." + name_ + ".missed", period - before->second - 1);
    told_[each] = period;
    for (const std::int64_t laid : lab.field(each, field_name_))
      field_.lay_in(static_cast<int>(laid >> amount_bits), static_cast<double>(laid & most_told) / 1000);
  }
  if (lab.period() > 0) field_.pass(std::chrono::duration<double>(lab.period_length()).count());
  laid_.clear();
  tell(lab);
}

}  // namespace arkmesh::scenarios::kit
