// The mean of a network's weights over the last updates.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace skybody::learn {

/// Exponential mean, in double. Near the end of a training, and at any time while its steps are
/// still long, weights fluctuate around good ones; their mean lies closer to the middle (Polyak and
/// Juditsky 1992, "Acceleration of stochastic approximation by averaging"). Training itself uses
/// the weights, not the mean.
class WeightAverage {
 public:
  /// @param size   weights
  /// @param steps  approximate length of the average in environment steps; 0: no mean
  WeightAverage(std::size_t size, double steps)
      : steps_(steps), values_(steps > 0.0 ? size : 0, 0.0) {}

  /// Adds the weights of an update.
  /// @param steps  environment steps since the previous update
  void add(std::span<const float> weights, double steps);
  /// The mean, or `weights` if there is none yet.
  std::vector<float> of(std::span<const float> weights) const;

  /// Passes the checkpointed arrays to `visitor` (state_blocks.h). @param self  const or not
  template <class Self, class Visitor>
  static void visit(Self& self, const std::string& name, Visitor& visitor) {
    visitor(name + ".values", self.values_.data(), self.values_.size());
    visitor(name + ".count", &self.count_, 1);
  }

 private:
  double steps_;
  std::vector<double> values_;
  std::int64_t count_ = 0;  ///< updates added
};

}  // namespace skybody::learn
