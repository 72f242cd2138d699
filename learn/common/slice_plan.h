// How environments are cut into slices, and rows of a rollout into minibatches.
#pragma once

#include <algorithm>
#include <cstdint>

namespace skybody::learn {

/// Slices that a learner's environments are cut into, whatever threads or machines there are;
/// fewer where there are fewer environments. Another number gives other bits.
inline constexpr int kSlices = 8;

/// The cuts, which follow from three numbers: everybody who knows these cuts alike.
///
/// A minibatch takes its share of each slice's rows, in the slice's shuffled order. An epoch sees
/// every row once: where the rows do not divide by the minibatch, all minibatches are a little
/// smaller, equal but for one row of each slice. For policies with a memory, the rows of an
/// environment (or robot) stay together: what is said of rows holds of these sequences.
class SlicePlan {
 public:
  /// @param rows_per_env  of a rollout: its steps, times the agents that are rows
  /// @param together      rows of a sequence, which divide rows_per_env; 1: each by itself
  SlicePlan(int envs, int rows_per_env, int minibatch, int together = 1)
      : envs_(envs),
        rows_per_env_(rows_per_env),
        together_(together),
        slices_(std::min(envs, kSlices)),
        minibatches_(static_cast<int>(
            std::min<std::int64_t>((rows() + minibatch - 1) / minibatch,
                                   std::int64_t{envs / slices_} * rows_per_env / together))) {}

  int slices() const { return slices_; }
  /// Environments first_env(s) ... first_env(s + 1) - 1 are slice s's.
  int first_env(int slice) const { return static_cast<int>(part(envs_, slice, slices_)); }
  int envs(int slice) const { return first_env(slice + 1) - first_env(slice); }
  int rows(int slice) const { return envs(slice) * rows_per_env_; }
  /// Of a rollout, over all slices.
  std::int64_t rows() const { return std::int64_t{envs_} * rows_per_env_; }

  /// Of an epoch.
  int minibatches() const { return minibatches_; }
  /// Rows first_row(s, m) ... first_row(s, m + 1) - 1 of slice s's order are minibatch m's.
  int first_row(int slice, int minibatch) const {
    return static_cast<int>(part(rows(slice) / together_, minibatch, minibatches_)) * together_;
  }
  /// Rows of a minibatch, over all slices.
  int minibatch_rows(int minibatch) const {
    int sum = 0;
    for (int s = 0; s < slices_; ++s) sum += first_row(s, minibatch + 1) - first_row(s, minibatch);
    return sum;
  }

 private:
  static std::int64_t part(std::int64_t whole, std::int64_t k, std::int64_t parts) {
    return whole * k / parts;
  }

  int envs_, rows_per_env_, together_, slices_, minibatches_;
};

}  // namespace skybody::learn
