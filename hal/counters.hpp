// Named totals that somebody can see: everything dropped, replaced, late or refused, with its reason.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace arkmesh::hal {

class Counters {
 public:
  // Names are dotted: what, what became of it, why: "world.refused.not_finite". They say whether it was lost: loss.hpp.
  void add(std::string_view name, std::uint64_t n = 1) {
    if (auto it = totals_.find(name); it != totals_.end())
      it->second += n;
    else
      totals_.emplace(name, n);
  }
  void set(std::string_view name, std::uint64_t total) {
    if (auto it = totals_.find(name); it != totals_.end())
      it->second = total;
    else
      totals_.emplace(name, total);
  }
  std::uint64_t operator[](std::string_view name) const {
    auto it = totals_.find(name);
    return it == totals_.end() ? 0 : it->second;
  }
  // Ascending by name.
  const std::map<std::string, std::uint64_t, std::less<>>& all() const { return totals_; }
  // Adds another's totals, each name behind `prefix`.
  void merge(const Counters& other, std::string_view prefix = {}) {
    for (const auto& [name, total] : other.totals_) add(std::string(prefix) + name, total);
  }

 private:
  std::map<std::string, std::uint64_t, std::less<>> totals_;
};

// Who has such totals.
class Counting {
 public:
  virtual Counters counters() const = 0;

 protected:
  ~Counting() = default;
};

}  // namespace arkmesh::hal
