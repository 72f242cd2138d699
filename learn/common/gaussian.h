// The policy's distribution, independent normals around the network's outputs, and draws from it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/simd/isa.h"

namespace skybody::learn {

/// Replaces each x by tanh x, with the function of the networks' units.
void apply_tanh(float* values, std::size_t count, Isa isa);

/// The actions' standard deviations, computed from the learned logarithms.
struct Deviations {
  std::vector<double> deviation, inverse;
  double log_sum = 0.0;  ///< sum of the logarithms

  /// Only the first call allocates.
  void update(std::span<const float> log_std);
};

/// Selects the noise of a step: equal numbers give equal noise.
struct NoiseSource {
  std::uint64_t seed = 0;
  std::uint64_t slice = 0;    ///< environments that are drawn together
  std::uint64_t rollout = 0;  ///< completed rollouts
  std::uint64_t step = 0;     ///< of the rollout
};

/// Fills `values` with independent standard normals. The bits are the same on v3 and v4.
void draw_noise(const NoiseSource& source, std::span<float> values, Isa isa = best_isa());

/// Draws the actions of some rows.
/// @param mean              rows x actions
/// @param noise             standard normals, rows x actions
/// @param action            row r at action + r * stride: mean + deviation noise
/// @param log_probability   row r at log_probability + r * stride: logarithm of the action's
///        density, without the constant -actions ln(2 pi) / 2
void draw_actions(const float* mean, const float* noise, int rows, const Deviations& deviations,
                  float* action, float* log_probability, int stride);

}  // namespace skybody::learn
