// A single environment: steps with Simbody, steps of integrators that choose their own times, and
// queries about one instant.
#pragma once

#include <memory>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "core/physics/bodies/joint_reactions.h"
#include "core/physics/contact/contact.h"
#include "core/physics/simbody/dynamics.h"
#include "core/physics/step/integrator.h"
#include "core/physics/step/step_plan.h"

namespace skybody {

/// Keeps only caches and work memory: no result depends on earlier calls. Not thread-safe.
class LaneStepper {
 public:
  /// @param plan     must outlive it
  /// @param simbody  null: created when first needed, which takes time and memory
  explicit LaneStepper(const StepPlan& plan, std::unique_ptr<Dynamics> simbody = nullptr);

  /// One physics step of a group of one lane, without contact. Its scratch is not used.
  /// @returns false if the lane is unchanged: the step gave a value that is not finite or beyond
  ///          kLargestState, or the dynamics failed (a std::runtime_error)
  bool advance(const StepCall& lane);

  /// Contact, applied as a correction after the step (contact_substeps.h).
  /// @returns false likewise, with the step uncorrected
  bool correct(const StepCall& lane);

  /// Generalised accelerations at the current state and t = 0 of the step, one per u.
  /// @throws Error if the parameters are not physical; std::runtime_error if the dynamics fails
  void accelerations(const StepCall& lane, double* udot);

  /// Forces and moments of joints on their bodies (joint_reactions.h), at the same instant.
  /// @param out  one per body
  /// @throws as accelerations
  void joint_reactions(const StepCall& lane, SpatialForce<double>* out);

  /// Appends the contacts.
  void add_contacts(const StepCall& lane, std::vector<Contact>& out);

 private:
  Dynamics* dynamics(const StepCall& lane);

  const StepPlan& plan_;
  std::unique_ptr<Integrator> integrator_;  ///< null: fixed steps
  std::unique_ptr<Dynamics> simbody_;
  AlignedArray<std::byte> scratch_, contact_scratch_;
  // For joint_reactions(); empty before its first call.
  std::vector<double> udot_;
  std::vector<BodyAcceleration> accelerations_;
};

}  // namespace skybody
