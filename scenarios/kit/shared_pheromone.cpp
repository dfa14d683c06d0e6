#include "scenarios/kit/shared_pheromone.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace arkmesh::scenarios::kit {
namespace {

// What was laid goes as bytes, cell by cell: how far it is from the cell before, and the amount, each seven bits a
// byte, lowest first, the top bit set but in the last. Zero ends them. Numbers of a field hold seven bytes each.
constexpr std::int64_t most_told = (std::int64_t{1} << 31) - 1;
constexpr std::size_t bytes_in_number = 7, most_bytes_of_cell = 3 + 5;  // 20 and 31 bits

class Writer {
 public:
  void number(std::int64_t value) {
    for (; value >= 0x80; value >>= 7) byte((value & 0x7f) | 0x80);
    byte(value);
  }
  std::vector<std::int64_t> take() { return std::move(out_); }

 private:
  void byte(std::int64_t value) {
    if (bytes_ % bytes_in_number == 0) out_.push_back(0);
    out_.back() |= value << (8 * (bytes_++ % bytes_in_number));
  }
  std::vector<std::int64_t> out_;
  std::size_t bytes_ = 0;
};

class Reader {
 public:
  explicit Reader(std::span<const std::int64_t> in) : in_(in) {}
  // 0 at the end, and for a number that is too large.
  std::int64_t number() {
    std::int64_t value = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      const std::int64_t next = byte();
      value |= (next & 0x7f) << shift;
      if ((next & 0x80) == 0) return value;
    }
    return 0;
  }

 private:
  std::int64_t byte() {
    const std::size_t at = read_++;
    if (at / bytes_in_number >= in_.size()) return 0;
    return in_[at / bytes_in_number] >> (8 * (at % bytes_in_number)) & 0xff;
  }
  std::span<const std::int64_t> in_;
  std::size_t read_ = 0;
};

}  // namespace

SharedPheromone::SharedPheromone(std::string name, const Pheromone::Settings& settings)
    : name_(std::move(name)), field_name_("kit." + name_), field_(settings) {}

void SharedPheromone::begin(lab::Lab& lab) const {
  field_.steps(std::chrono::duration<double>(lab.period_length()).count());  // what cannot be is said at once
  if (!lab.tells_all_each_period())
    throw std::invalid_argument(fmt::format(
        "the pheromone {} needs every state completely; remove gate.exchange and the periods of its states", name_));
  lab.declare({.name = field_name_,
               .length = most_cells * most_bytes_of_cell / bytes_in_number + 1,
               .low = 0,
               .high = (std::int64_t{1} << (8 * bytes_in_number)) - 1,
               .up_to = true});
  lab.publish(field_name_, {});
}

void SharedPheromone::lay(lab::Lab& lab, const hal::Pose& in_arena, double amount) {
  const hal::Pose at = in_field(lab, in_arena);
  const int cell = field_.cell_at({at.x_m, at.y_m});
  if (cell < 0) return lab.counts().add("kit." + name_ + ".outside");
  const bool is_amount = amount >= least_amount && amount <= most_amount;
  if (!is_amount || (laid_.size() == most_cells && !laid_.contains(cell)))
    return lab.counts().add("kit." + name_ + ".not_laid");
  std::int64_t& here = laid_[cell];
  here = std::min<std::int64_t>(most_told, here + std::llround(amount * 1000));
}

void SharedPheromone::tell(lab::Lab& lab) const {
  Writer told;
  int before = -1;
  for (const auto& [cell, amount] : laid_) {
    told.number(cell - std::exchange(before, cell));
    told.number(amount);
  }
  lab.publish(field_name_, told.take());
}

// What another lab tells may be anything.
void SharedPheromone::lay_told(lab::Lab& lab, std::span<const std::int64_t> told) {
  Reader in(told);
  std::int64_t cell = -1;
  while (const std::int64_t step = in.number()) {
    const std::int64_t amount = in.number();
    cell += step;
    if (cell >= static_cast<std::int64_t>(field_.cells().size()) || amount < 1 || amount > most_told)
      return lab.counts().add("kit." + name_ + ".malformed");
    field_.lay_in(static_cast<int>(cell), static_cast<double>(amount) / 1000);
  }
}

// To grow: what each lab told, behind how many numbers that is.
void SharedPheromone::on_period(lab::Lab& lab) {
  std::vector<std::int64_t> laid;
  for (const std::string& each : lab.labs()) {
    const std::uint32_t period = lab.state(each).period;
    const auto before = told_.find(each);
    if (before != told_.end() && period == before->second) continue;  // nothing new of it
    if (before != told_.end() && period > before->second + 1)
      lab.counts().add("kit." + name_ + ".missed", period - before->second - 1);
    told_[each] = period;
    const std::vector<std::int64_t>& told = lab.field(each, field_name_);
    if (told.empty()) continue;
    laid.push_back(std::ssize(told));
    laid.insert(laid.end(), told.begin(), told.end());
  }
  for (const lab::Grown& one : lab.grow(field_name_, std::move(laid))) {
    for (std::span<const std::int64_t> rest = one.happened; !rest.empty();) {
      const auto n = static_cast<std::size_t>(std::clamp<std::int64_t>(rest[0], 0, std::ssize(rest) - 1));
      lay_told(lab, rest.subspan(1, n));
      rest = rest.subspan(1 + n);
    }
    if (one.period > 0) field_.pass(std::chrono::duration<double>(lab.period_length()).count());
  }
  laid_.clear();
  tell(lab);
}

}  // namespace arkmesh::scenarios::kit
