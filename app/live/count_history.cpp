#include "app/live/count_history.hpp"

#include <fmt/format.h>

namespace arkmesh::app {
namespace {

template <class Number>
void keep_every_second(std::vector<Number>& all) {
  for (std::size_t i = 0; 2 * i < all.size(); ++i) all[i] = all[2 * i];
  all.resize((all.size() + 1) / 2);
}

}  // namespace

void CountHistory::note(std::int64_t t_us, const hal::Counters& counts) {
  if (t_us < newest_us_) *this = {};
  if (t_us == newest_us_) return;
  newest_us_ = t_us;
  if (noted_++ % every_ != 0) return;
  for (const auto& [name, total] : counts.all())
    if (curves_.contains(name) || curves_.size() < max_names) {
      std::vector<std::uint64_t>& curve = curves_[name];
      curve.resize(t_s_.size());
      curve.push_back(total);
    }
  t_s_.push_back(static_cast<double>(t_us) * 1e-6);
  for (auto& [name, curve] : curves_) curve.resize(t_s_.size(), curve.back());
  if (t_s_.size() < max_moments) return;
  keep_every_second(t_s_);
  for (auto& [name, curve] : curves_) keep_every_second(curve);
  every_ *= 2;
}

nlohmann::json CountHistory::series(std::string_view lab) const {
  nlohmann::json out = nlohmann::json::array();
  for (const auto& [name, curve] : curves_)
    out.push_back({{"name", fmt::format("{} {}", lab, name)}, {"t_s", t_s_}, {"y", curve}});
  return out;
}

}  // namespace arkmesh::app
