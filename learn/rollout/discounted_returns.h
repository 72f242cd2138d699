// Discounted returns of running episodes, whose deviation is the scale of rewards.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace skybody::learn {

/// R_t = discount R_(t-1) + r_t of each row, from the beginning of its episode. Rewards divided by
/// the deviation of all R have values of about one.
class DiscountedReturns {
 public:
  DiscountedReturns(int rows, double discount)
      : discount_(discount), returns_(static_cast<std::size_t>(rows)) {}

  /// Adds a reward. @returns the row's return with it
  /// @param goes_on  false: the row's next reward is the first one of an episode
  double add(int row, float reward, bool goes_on) {
    double& current = returns_[static_cast<std::size_t>(row)];
    const double sum = current * discount_ + static_cast<double>(reward);
    current = goes_on ? sum : 0.0;
    return sum;
  }
  /// The row's next reward is the first one of an episode.
  void restart(int row) { returns_[static_cast<std::size_t>(row)] = 0.0; }

  /// Passes the checkpointed array to `visitor` (state_blocks.h). @param self  const or not
  template <class Self, class Visitor>
  static void visit(Self& self, const std::string& name, Visitor& visitor) {
    visitor(name, self.returns_.data(), self.returns_.size());
  }

 private:
  double discount_;
  std::vector<double> returns_;
};

}  // namespace skybody::learn
