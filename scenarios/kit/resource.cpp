#include "scenarios/kit/resource.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "hal/fixed_math.hpp"

namespace arkmesh::scenarios::kit {

Resource::Resource(const Settings& settings) : settings_(settings), stock_(settings.capacity) {
  if (!(settings.capacity > 0) || !std::isfinite(settings.capacity))
    throw std::invalid_argument(
        fmt::format("a capacity of {:g} is not possible; give a positive one", settings.capacity));
  for (const double value : {settings.growth_per_s, settings.rate_per_s, settings.regrows_at_once_below})
    if (!(value >= 0) || !std::isfinite(value))
      throw std::invalid_argument(fmt::format("{:g} is no rate of a resource; give 0 or more", value));
  if (settings.regrows_at_once_below >= settings.capacity)
    throw std::invalid_argument("a resource that regrows below its capacity would always be full; lower regrows_below");
}

// First it grows, by the exact solution of the logistic equation, then robots take.
double Resource::pass(double seconds, int robots) {
  if (!(seconds > 0)) return 0;
  if (settings_.growth_per_s > 0 && stock_ > 0) {
    const double factor = hal::fixed::exp(settings_.growth_per_s * seconds);
    stock_ =
        std::isfinite(factor) ? stock_ * factor / (1 + stock_ / settings_.capacity * (factor - 1)) : settings_.capacity;
  }
  double n = robots;
  if (settings_.use == Use::by_pairs) n *= n;
  if (settings_.use == Use::shared) n = std::min(n, 1.0);
  return take(settings_.capacity * settings_.rate_per_s * seconds * n);
}

double Resource::take(double amount) {
  const double taken = std::clamp(amount, 0.0, stock_);
  stock_ -= taken;
  if (stock_ < settings_.regrows_at_once_below) stock_ = settings_.capacity;
  return taken;
}

double Resource::put(double amount) {
  const double put = std::clamp(amount, 0.0, settings_.capacity - stock_);
  stock_ += put;
  return put;
}

}  // namespace arkmesh::scenarios::kit
