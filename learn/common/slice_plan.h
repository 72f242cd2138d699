// Divides environments into slices, and rows of a rollout into minibatches.
#pragma once

#include <algorithm>
#include <cstdint>

namespace skybody::learn {

/// Number of slices of a learner's environments, independent of threads or machines; fewer if there
/// are fewer environments. Another number gives other bits.
inline constexpr int kSlices = 8;

/// The division into slices and minibatches. It follows from the constructor's numbers alone, so
/// that every thread and process computes the same.
///
/// A minibatch takes its share of each slice's rows, in the slice's shuffled order. An epoch uses
/// every row once: if the rows are not a multiple of the minibatch, all minibatches are slightly
/// smaller, and their sizes differ by at most one row per slice. For policies with a memory, the
/// rows of an environment (or robot) stay together as a sequence, and sequences take the place of
/// rows.
class SlicePlan {
 public:
  /// @param rows_per_env  of a rollout: its steps, times the agents with rows of their own
  /// @param together      rows of a sequence, which divide rows_per_env; 1: no sequences
  SlicePlan(int envs, int rows_per_env, int minibatch, int together = 1)
      : envs_(envs),
        rows_per_env_(rows_per_env),
        together_(together),
        slices_(std::min(envs, kSlices)),
        minibatches_(static_cast<int>(
            std::min<std::int64_t>((rows() + minibatch - 1) / minibatch,
                                   std::int64_t{envs / slices_} * rows_per_env / together))) {}

  int slices() const { return slices_; }
  /// Slice s has the environments first_env(s) ... first_env(s + 1) - 1.
  int first_env(int slice) const { return static_cast<int>(part(envs_, slice, slices_)); }
  int envs(int slice) const { return first_env(slice + 1) - first_env(slice); }
  int rows(int slice) const { return envs(slice) * rows_per_env_; }
  /// Rows of a rollout, over all slices.
  std::int64_t rows() const { return std::int64_t{envs_} * rows_per_env_; }

  /// Minibatches of an epoch.
  int minibatches() const { return minibatches_; }
  /// Minibatch m has the rows first_row(s, m) ... first_row(s, m + 1) - 1 of slice s's order.
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
