// The mean of a network's weights over the last updates.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace skybody::learn {

/// Exponential mean, in double. Near its end, and at every moment of a training whose steps are
/// still long, weights walk about good ones: their mean over the walk lies closer to the middle
/// (Polyak and Juditsky 1992, "Acceleration of stochastic approximation by averaging"). Training
/// itself goes on with the weights as they are.
class WeightAverage {
 public:
  /// @param size   weights
  /// @param steps  environment steps that the mean reaches back, about; 0: there is no mean
  WeightAverage(std::size_t size, double steps)
      : steps_(steps), values_(steps > 0.0 ? size : 0, 0.0) {}

  /// Takes in the weights of an update.
  /// @param steps  environment steps since the update before
  void add(std::span<const float> weights, double steps);
  /// The mean; `weights` as they are where there is none yet.
  std::vector<float> of(std::span<const float> weights) const;

  /// Names to `visitor` what a checkpoint holds (state_blocks.h). @param self  const or not
  template <class Self, class Visitor>
  static void visit(Self& self, const std::string& name, Visitor& visitor) {
    visitor(name + ".values", self.values_.data(), self.values_.size());
    visitor(name + ".count", &self.count_, 1);
  }

 private:
  double steps_;
  std::vector<double> values_;
  std::int64_t count_ = 0;  ///< updates taken in
};

}  // namespace skybody::learn
