// Advantages of the transitions of a rollout.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace skybody::learn {

/// Factors of the estimate.
struct AdvantageTerms {
  float discount = 0.99f;     ///< gamma, 0 ... 1
  float lambda = 0.95f;       ///< 0: one-step errors, 1: sums of rewards
  float reward_scale = 1.0f;  ///< values are in units of rewards times this
};

/// Generalized advantage estimation (Schulman et al. 2016, arXiv 1506.02438, eq. 16): with the
/// values V of a rollout's observations,
///
///   error_t     = scale r_t + discount V_(t+1) - V_t,
///   advantage_t = error_t + discount lambda advantage_(t+1),
///
/// where nothing follows the end of an episode but the value of a truncated one. A step has `rows`
/// rows: environments, or the robots of a team.
class AdvantageEstimator {
 public:
  AdvantageEstimator(int steps, int rows)
      : steps_(steps),
        rows_(rows),
        reward_(at(steps, 0)),
        goes_on_(reward_.size()),
        end_value_(reward_.size()),
        value_(at(steps + 1, 0)),
        following_(static_cast<std::size_t>(rows)) {}

  int steps() const { return steps_; }
  int rows() const { return rows_; }
  /// Index of a transition: rows of a step are neighbours.
  std::size_t at(int step, int row) const {
    return static_cast<std::size_t>(step) * static_cast<std::size_t>(rows_) +
           static_cast<std::size_t>(row);
  }

  /// Begins a rollout: no episode is truncated.
  void begin() { std::fill(end_value_.begin(), end_value_.end(), 0.0f); }
  /// Sets a transition's reward. @param goes_on  false: it ended the episode
  void set(std::size_t index, float reward, bool goes_on) {
    reward_[index] = reward;
    goes_on_[index] = goes_on ? 1.0f : 0.0f;
  }
  /// Sets the value of the last observation of an episode that this transition truncated.
  void set_end_value(std::size_t index, float value) { end_value_[index] = value; }
  /// Value of each transition's observation, and, at(steps, row), of the observations after the
  /// last step. Written by the caller before estimate().
  std::span<float> values() { return value_; }

  std::span<const float> values() const { return value_; }
  std::span<const float> rewards() const { return reward_; }
  std::span<const float> goes_on() const { return goes_on_; }  ///< 1 or 0
  std::span<const float> end_values() const { return end_value_; }

  /// Calls take(step, row, advantage, target) for every transition, from the last step to the
  /// first. The target of the value function is advantage + value.
  template <class Take>
  void estimate(const AdvantageTerms& terms, const Take& take) {
    std::fill(following_.begin(), following_.end(), 0.0f);
    for (int step = steps_ - 1; step >= 0; --step) {
      for (int row = 0; row < rows_; ++row) {
        const std::size_t i = at(step, row), next = at(step + 1, row);
        const float kept = goes_on_[i] * terms.discount;
        const float error = reward_[i] * terms.reward_scale + terms.discount * end_value_[i] +
                            kept * value_[next] - value_[i];
        float& following = following_[static_cast<std::size_t>(row)];
        following = error + kept * terms.lambda * following;
        take(step, row, following, following + value_[i]);
      }
    }
  }

 private:
  int steps_, rows_;
  std::vector<float> reward_, goes_on_, end_value_;  ///< per transition
  std::vector<float> value_;
  std::vector<float> following_;  ///< advantage of the following step, per row
};

}  // namespace skybody::learn
