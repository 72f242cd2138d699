// Tracking errors of references: output of `skybody run` for robots with a controller `reference`.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/simulation/simulation.h"

namespace skybody {

/// The yaw for comparisons with a goal's or a reference's yaw: the turn about e_z before the
/// shortest turn that tilts the body's z axis, as in flatness.h. The twist of the rotation about
/// e_z, in [-2 pi, 2 pi] [rad].
double yaw_of(const Quat<double>& rotation);

/// A controller that reports whether its own limits are active.
struct LawLimit {
  std::string controller;  ///< name of the instance
  int info = 0;            ///< index among the infos: above 0 while a limit is active
};

/// A controller `reference` of a scenario.
struct FlownReference {
  std::string kind;  ///< of the path
  int robot = 0;
  int body = 0;        ///< world body that follows it: the robot's base
  int info = 0;        ///< first value among the infos: position [m] (W), then yaw [rad]
  double begin = 0.0;  ///< time at which approach and ramp are over [s]; errors count from there
  std::vector<LawLimit> limits;  ///< of the controllers that follow it
};

/// All references of a scenario, in the order of its controllers.
std::vector<FlownReference> flown_references(const CompiledScenario& compiled);

/// Position and yaw of each reference in the current state, four values each; after a reset the
/// first values.
std::vector<double> reference_places(const Simulation& simulation,
                                     const std::vector<FlownReference>& references);

/// Errors of one reference over an episode. NaN if there are no samples.
struct ReferenceError {
  double rms[3] = {};      ///< by axis of W [m]
  double total = 0.0;      ///< root of the mean squared distance [m]
  double max = 0.0;        ///< [m]
  double yaw = 0.0;        ///< RMS [rad]
  double effort = 0.0;     ///< mean of the sum of the rotors' cubed speeds, relative to hover
  double saturated = 0.0;  ///< fraction of the steps in which a rotor's command is at a limit
  std::vector<double> limited =
      {};  ///< for each LawLimit: fraction of the steps in which it is active
};

/// Accumulates errors over an episode.
class ReferenceErrors {
 public:
  explicit ReferenceErrors(const CompiledScenario& compiled);

  /// Adds the state after a step.
  void add(const Simulation& simulation);
  std::vector<ReferenceError> errors() const;

 private:
  struct Sum {
    double square[3] = {}, max = 0.0, yaw = 0.0, effort = 0.0;
    std::size_t saturated = 0, count = 0;
    std::vector<std::size_t> limited = {};  ///< steps, for each LawLimit
  };
  void add_effort(const Simulation& simulation, const FlownReference& reference, Sum& sum) const;

  const CompiledScenario& compiled_;
  std::vector<FlownReference> references_;
  std::vector<Sum> sums_;
  std::vector<double> hover_speed_;  ///< of each reference's robot [rad/s]
};

/// A table with one row per episode and reference. Empty without references.
/// @param episodes  the errors of each
std::string reference_table(const CompiledScenario& compiled,
                            const std::vector<std::vector<ReferenceError>>& episodes);

}  // namespace skybody
