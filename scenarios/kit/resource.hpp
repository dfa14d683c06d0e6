// A stock that robots use up and that grows back.
#pragma once

namespace arkmesh::scenarios::kit {

class Resource {
 public:
  // n robots take rate * n, rate * n^2, or, however many they are, rate of the capacity a second.
  enum class Use { by_each, by_pairs, shared };
  struct Settings {
    double capacity = 1;
    double growth_per_s = 0;  // r of logistic growth, dx/dt = r x (1 - x / capacity)
    double rate_per_s = 0;    // of use, as a share of the capacity
    Use use = Use::by_each;
    double regrows_at_once_below = 0;  // a stock that sinks below is full again; 0: never
  };
  // Full at first. Throws std::invalid_argument with one sentence for settings that make no sense.
  explicit Resource(const Settings& settings);

  double stock() const { return stock_; }
  // Lets time pass with so many robots on it. Returns what they took.
  double pass(double seconds, int robots);
  // Takes so much at once, as far as it is there; and puts back, up to the capacity. Both return how much that was.
  double take(double amount);
  double put(double amount);

 private:
  Settings settings_;
  double stock_;
};

}  // namespace arkmesh::scenarios::kit
