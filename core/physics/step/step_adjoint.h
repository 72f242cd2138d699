// Derivatives of physics steps of a lane group, for learning through the dynamics.
#pragma once

#include <cstdint>

#include "core/base/aligned_array.h"
#include "core/physics/step/adjoint_kernel.h"

namespace skybody {

/// Goes back through steps of groups of kGroupLanes lanes. Immutable, thread-safe.
class StepAdjoint {
 public:
  /// @param world  must outlive it
  /// @throws Error if steps choose their own times, or Simbody takes them
  explicit StepAdjoint(const World& world);

  const StepPlan& plan() const { return plan_; }
  /// Whether pull_back() knows this world: one free robot with level rotors, stepped by the
  /// midpoint rule, of which effects hold nothing. Others go on dual numbers (dual_kernels.h).
  bool has_closed_form() const { return has_closed_form_; }

  /// Room for what derives from the parameters of a group.
  AlignedArray<double> make_derived() const;

  /// Makes ready for the parameters of a group. Before pull_back() wherever they may be others.
  /// @param params  the parameter block, in lanes
  void derive(const double* params, std::uint32_t lanes, AlignedArray<double>& derived) const;

  /// Where has_closed_form().
  /// @param values    state words from `q` on, up to the parameters, as they were before the step,
  ///                  commands as in it, in lanes
  /// @param params    the parameter block, in lanes
  /// @param adjoints  of the same words: derivatives of a sum by what they are after the step;
  ///                  overwritten by those by what they were before it. Lanes beyond `lanes` stay
  void pull_back(const double* values, const double* params, const AlignedArray<double>& derived,
                 std::uint32_t lanes, double* adjoints) const;

 private:
  StepPlan plan_;
  bool has_closed_form_;
  AdjointKernel* kernel_;
};

}  // namespace skybody
