// Advances one environment by one physics step on a chosen dynamics with a chosen integrator.
#pragma once

#include <memory>
#include <vector>

#include "core/physics/contact.h"
#include "core/physics/dynamics.h"
#include "core/physics/lane_state.h"
#include "core/physics/world.h"

namespace skybody {

/// A state beyond this [m, rad, m/s, rad/s] has diverged: it is a thousand kilometres away, or
/// faster than any rotor.
inline constexpr double kLargestState = 1e6;

/// The physics of one environment on the one-by-one path. Not thread-safe; use one per environment.
/// Holds only what can be derived from World and LaneState (a cache): results never depend on which
/// states it saw before.
class Stepper {
 public:
  virtual ~Stepper() = default;

  /// Makes `state.bodies` current after q, u or params were changed from outside.
  virtual void update_bodies(LaneState& state) = 0;

  /// Advances q, u, rotor speeds and bodies by exactly dt, the rotor command, wrenches and drives
  /// held.
  /// @returns false if the step gave a value that is not finite or beyond 1e6 (free robots: rates
  /// of
  ///          turn, and the magnitudes of all else added up), or the dynamics gave up (a
  ///          std::runtime_error); then the state is as it was before the call
  virtual bool advance(LaneState& state) = 0;

  /// Whether the last advance, come through or not, went on Simbody.
  virtual bool was_on_simbody() const = 0;

  /// Generalised accelerations at the present state and t = 0 of the step, one per u.
  /// @throws Error if the parameters are not physical; std::runtime_error if the dynamics gives up
  virtual void accelerations(const LaneState& state, double* udot) = 0;

  /// Appends the contacts of bodies with one another and with obstacles.
  /// @throws as accelerations
  virtual void add_contacts(const LaneState& state, std::vector<Contact>& out) = 0;
};

/// A stepper over any dynamics of this world with the scenario's integrator.
std::unique_ptr<Stepper> make_stepper(const World& world, std::unique_ptr<Dynamics> dynamics);

/// What steps a world.
enum class DynamicsUse {
  kTree,      ///< the tree dynamics, always
  kSimbody,   ///< Simbody, always
  kHandOver,  ///< tree where nothing is within reach, else Simbody (hand_over_dynamics.h)
};

/// `auto` takes tree where that can do the world (why_not_tree), else hands over.
/// @throws MarkedError at `dynamics: tree` if tree cannot do the world (message says why)
DynamicsUse chosen_dynamics(const World& world);

/// Builds once whatever steppers of this world will ever build, but for the geometries of contact:
/// on a hand-over they make Simbody's system in the midst of a flight.
/// @throws as make_stepper
void check_world(const World& world);

/// A stepper over the dynamics and the integrator that the scenario asks for.
/// @throws MarkedError as chosen_dynamics
/// @throws Error if the world cannot be built (message names the body and the reason)
std::unique_ptr<Stepper> make_stepper(const World& world);

/// A stepper over tree dynamics alone: bodies do not meet one another, nor obstacles.
std::unique_ptr<Stepper> make_tree_stepper(const World& world);

/// A stepper over Simbody with the scenario's integrator.
/// @throws Error if the world cannot be built (message names the body and the reason).
std::unique_ptr<Stepper> make_simbody_stepper(const World& world);

}  // namespace skybody
