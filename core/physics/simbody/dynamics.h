// Simbody behind the equations of motion: accelerations of a world's bodies under given forces.
// C++17, without Simbody's types.
#pragma once

#include <memory>

#include "core/physics/bodies/spatial_force.h"
#include "core/physics/world/lane_state.h"
#include "core/physics/world/world.h"

namespace skybody {

/// Dynamics of one environment. Coordinates are ours throughout (JointType). Not thread-safe.
class Dynamics {
 public:
  virtual ~Dynamics() = default;

  /// Takes the mass properties over from the parameter block; cheap if they are as before.
  /// @throws Error (naming the body where one is to blame) if nothing can be built from them
  virtual void set_params(const double* params) = 0;

  /// Generalised accelerations [per u]. Bases of driven robots get zero.
  /// @param q             quaternions need not be of norm 1
  /// @param body_forces   one per body
  /// @param joint_forces  one per u
  /// @throws std::runtime_error if the dynamics gives up
  virtual void accelerations(const double* q, const double* u,
                             const SpatialForce<double>* body_forces, const double* joint_forces,
                             double* udot) = 0;

  /// Which couplings hold in the next calls; those that are springs never do.
  /// @param held  one for each of the scenario's couplings
  virtual void hold(const bool* held) = 0;

  /// The same as accelerations(), with the couplings that hold.
  virtual void constrained_accelerations(const double* q, const double* u,
                                         const SpatialForce<double>* body_forces,
                                         const double* joint_forces, double* udot) = 0;

  /// Brings q and u to where the couplings that hold allow them to be. @throws likewise
  virtual void project(double* q, double* u) = 0;

  /// Motion of all bodies as the dynamics itself has it; for tests against our kinematics.
  virtual void body_states(const double* q, const double* u, BodyState* bodies) = 0;
};

/// Simbody's dynamics. Drives are read from `world.drives`.
/// @param params  with which it begins
/// @throws Error (naming the body where one is to blame) if nothing can be built from them
std::unique_ptr<Dynamics> make_simbody_dynamics(const World& world, const double* params);
/// Builds Simbody's system of the nominal world once. @throws Error likewise
void check_simbody(const World& world);

}  // namespace skybody
