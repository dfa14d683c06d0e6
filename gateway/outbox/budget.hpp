// So much a second, of messages or of bytes, and a second's worth at once after a pause. Pure: the caller keeps the
// time.
#pragma once

#include <algorithm>
#include <chrono>
#include <limits>

namespace arkmesh::gateway {

class Budget {
 public:
  static constexpr double unlimited = std::numeric_limits<double>::infinity();
  using Time = std::chrono::microseconds;  // any monotonic one

  Budget() : Budget(unlimited) {}
  explicit Budget(double per_s) : per_s_(per_s), most_(std::max(per_s, 1.0)), left_(most_) {}

  // Whether `n` may be used now. More than a second's worth at once may when all of that is there, and is paid off.
  bool has(double n, Time now) {
    const double passed_s = std::max(std::chrono::duration<double>(now - filled_).count(), 0.0);
    if (per_s_ != unlimited) left_ = std::min(most_, left_ + per_s_ * passed_s);
    filled_ = std::max(filled_, now);
    return left_ >= std::min(n, most_);
  }
  // After has().
  void use(double n) {
    if (per_s_ != unlimited) left_ -= n;
  }

 private:
  double per_s_, most_, left_;
  Time filled_{0};
};

}  // namespace arkmesh::gateway
