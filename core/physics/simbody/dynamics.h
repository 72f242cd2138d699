// Interface to Simbody's dynamics: accelerations of a world's bodies under given forces. C++17,
// without Simbody's types.
#pragma once

#include <memory>

#include "core/physics/bodies/spatial_force.h"
#include "core/physics/world/lane_state.h"
#include "core/physics/world/world.h"

namespace skybody {

/// Dynamics of one environment. All coordinates follow JointType, not Simbody. Not thread-safe.
class Dynamics {
 public:
  virtual ~Dynamics() = default;

  /// Copies the mass properties from the parameter block; cheap if they have not changed.
  /// @throws Error (naming the body, if one is the cause) if no system can be built from them
  virtual void set_params(const double* params) = 0;

  /// Generalised accelerations [per u]. Bases of driven robots get zero.
  /// @param q             quaternions need not be of norm 1
  /// @param body_forces   one per body
  /// @param joint_forces  one per u
  /// @throws std::runtime_error if the computation fails
  virtual void accelerations(const double* q, const double* u,
                             const SpatialForce<double>* body_forces, const double* joint_forces,
                             double* udot) = 0;

  /// Sets the active couplings of the next calls; springs are never active.
  /// @param held  one per coupling of the scenario
  virtual void hold(const bool* held) = 0;

  /// The same as accelerations(), with the active couplings.
  virtual void constrained_accelerations(const double* q, const double* u,
                                         const SpatialForce<double>* body_forces,
                                         const double* joint_forces, double* udot) = 0;

  /// Projects q and u onto the constraints of the active couplings. @throws likewise
  virtual void project(double* q, double* u) = 0;

  /// Motion of all bodies computed by Simbody; for tests against forward_kinematics().
  virtual void body_states(const double* q, const double* u, BodyState* bodies) = 0;
};

/// Simbody's dynamics. Reads the drives from `world.drives`.
/// @param params  the initial parameters
/// @throws Error (naming the body, if one is the cause) if no system can be built from them
std::unique_ptr<Dynamics> make_simbody_dynamics(const World& world, const double* params);
/// Builds Simbody's system of the nominal world once, as a check. @throws Error likewise
void check_simbody(const World& world);

}  // namespace skybody
