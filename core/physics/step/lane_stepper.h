// One environment by itself: steps on Simbody, steps of integrators that choose their own times,
// and questions about one instant.
#pragma once

#include <memory>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/physics/bodies/joint_reactions.h"
#include "core/physics/contact/contact.h"
#include "core/physics/simbody/dynamics.h"
#include "core/physics/step/integrator.h"
#include "core/physics/step/step_plan.h"

namespace skybody {

/// Holds caches and work space only: no result depends on earlier calls. Not thread-safe.
class LaneStepper {
 public:
  /// @param plan     must outlive it
  /// @param simbody  null: made when first needed, which takes time and memory
  explicit LaneStepper(const StepPlan& plan, std::unique_ptr<Dynamics> simbody = nullptr);

  /// One physics step of a group of one lane, without contact. Its scratch is not used.
  /// @returns false if the lane is as it was: the step gave a value that is not finite or beyond
  ///          kLargestState, or the dynamics gave up (a std::runtime_error)
  bool advance(const StepCall& lane);

  /// What contact makes of a step that has been taken (contact_correction.h).
  /// @returns false likewise, with the step uncorrected
  bool correct(const StepCall& lane);

  /// Generalised accelerations at the present state and t = 0 of the step, one per u.
  /// @throws Error if the parameters are not physical; std::runtime_error if the dynamics gives up
  void accelerations(const StepCall& lane, double* udot);

  /// What joints exert on the bodies that they move (joint_reactions.h), at the same instant.
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
  // Of joint_reactions(); empty until then.
  std::vector<double> udot_;
  std::vector<BodyAcceleration> accelerations_;
};

}  // namespace skybody
