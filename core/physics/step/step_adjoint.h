// Gradients of physics steps of a lane group, for learning through the dynamics.
#pragma once

#include <cstdint>

#include "core/base/simd/aligned_array.h"
#include "core/physics/step/adjoint_kernel.h"

namespace skybody {

/// Adjoint of steps of groups of kGroupLanes lanes. Immutable, thread-safe.
class StepAdjoint {
 public:
  /// @param world  must outlive it
  /// @throws Error if the integrator chooses its own times, or the dynamics is Simbody
  explicit StepAdjoint(const World& world);

  const StepPlan& plan() const { return plan_; }
  /// Whether pull_back() supports this world: one free robot with level rotors, stepped by the
  /// midpoint rule, without held inputs. Other worlds use dual numbers (dual_kernels.h).
  bool has_closed_form() const { return has_closed_form_; }

  /// Allocates memory for the values derived from a group's parameters.
  AlignedArray<double> make_derived() const;

  /// Computes the values derived from a group's parameters. Must precede pull_back() after a change
  /// of parameters.
  /// @param params  the parameter block, in lanes
  void derive(const double* params, std::uint32_t lanes, AlignedArray<double>& derived) const;

  /// Adjoint of one step; requires has_closed_form().
  /// @param values    state words from `q` on, up to the parameters, as before the step, with the
  ///                  step's commands, in lanes
  /// @param params    the parameter block, in lanes
  /// @param adjoints  of the same words: in: derivatives of a scalar by their values after the
  ///                  step; out: by their values before it. Lanes that are not in `lanes` stay
  ///                  unchanged
  void pull_back(const double* values, const double* params, const AlignedArray<double>& derived,
                 std::uint32_t lanes, double* adjoints) const;

 private:
  StepPlan plan_;
  bool has_closed_form_;
  AdjointKernel* kernel_;
};

}  // namespace skybody
