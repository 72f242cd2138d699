// The inputs of a slice's policy and value function: the present ones, and those of a horizon.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "core/env/compiled_scenario.h"
#include "core/physics/world/lane_values.h"
#include "learn/network/image_rows.h"

namespace skybody::learn {

/// A row has the values of an observation, which a policy sees, then the privileged ones, if there
/// is a value function. Images are kept in the type of their columns, for each transition of one
/// group's horizon: they become floats only for one pass through a network.
class HorizonInputs {
 public:
  /// @param compiled  must outlive it
  /// @param steps   transitions of a horizon
  /// @param groups  of kGroupLanes environments
  HorizonInputs(const CompiledScenario& compiled, bool has_value, int steps, int groups);

  int width() const { return width_; }    ///< values of a row
  int stride() const { return stride_; }  ///< of rows of a horizon
  bool has_images() const { return !images_.empty(); }
  /// Row of the task's values that is value k of a row; -1: a sensor's, which has no derivative.
  int task_row(int k) const { return task_rows_[static_cast<std::size_t>(k)]; }

  /// Rows of a transition or a reset, in which this has the observations.
  Rows outcome(float* reward, std::uint64_t* status);
  /// Makes lane `lane` of the last outcome() the present observation of environment `env`.
  void take(int env, int lane);
  /// Present values of an environment, not normalised.
  std::span<const float> present(int env) const {
    return {present_.data() + at(env), static_cast<std::size_t>(width_)};
  }
  /// (present - mean) scale
  void normalize(int env, std::span<const double> mean, std::span<const double> scale,
                 float* to) const;
  /// Keeps the present images of these lanes, as those before transition `t`.
  void keep_images(const StateGroup& group, std::uint32_t lanes, int t);

  /// Normalised, before transition `t`.
  float* row(int t, int lane) { return rows_.data() + place(t, lane) * stride_; }
  ImageRows images(int t) const {
    return {images_.data(), static_cast<std::size_t>(place(t, 0)), nullptr};
  }
  /// Normalised, after the last transition.
  float* end(int lane) { return end_.data() + std::ptrdiff_t{1} * lane * stride_; }
  void clear_ends() { end_.fill_zero(); }

  /// Passes the checkpointed arrays to `visitor` (state_blocks.h). @param self  const or not
  template <class Self, class Visitor>
  static void visit(Self& self, const std::string& name, Visitor& visitor) {
    visitor(name + ".observations", self.present_.data(), self.present_.size());
  }

 private:
  std::size_t at(int env) const {
    return static_cast<std::size_t>(env) * static_cast<std::size_t>(width_);
  }
  static std::ptrdiff_t place(int t, int lane) { return std::ptrdiff_t{t} * kGroupLanes + lane; }

  const CompiledScenario& compiled_;
  int seen_, width_, stride_;
  std::vector<int> task_rows_;
  AlignedArray<float> observation_, privileged_;  ///< of outcome(), per lane
  AlignedArray<float> present_;                   ///< of all environments
  AlignedArray<float> rows_, end_;
  std::vector<AlignedArray<std::uint8_t>> images_;
};

}  // namespace skybody::learn
