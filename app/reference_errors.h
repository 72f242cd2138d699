// How well references were followed: what `skybody run` tells of robots with a controller
// `reference`.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/simulation/simulation.h"

namespace skybody {

/// The yaw of everything that is compared with a goal's or a reference's: the turn about e_z before
/// the shortest turn that tilts z of the body, as in flatness.h. The twist of the rotation about
/// e_z, in [-2 pi, 2 pi] [rad].
double yaw_of(const Quat<double>& rotation);

/// A controller that tells whether limits of its own cut what it asks for.
struct LawLimit {
  std::string controller;  ///< name of the instance
  int info = 0;            ///< place among the infos: above 0 where they do
};

/// A controller `reference` of a scenario.
struct FlownReference {
  std::string kind;  ///< of path
  int robot = 0;
  int body = 0;                  ///< world body that follows it: the robot's base
  int info = 0;                  ///< first value among the infos: position [m] (W), then yaw [rad]
  double begin = 0.0;            ///< when approach and ramp are over [s]; errors count from there
  std::vector<LawLimit> limits;  ///< of the laws that follow it
};

/// All of a scenario, in the order of its controllers.
std::vector<FlownReference> flown_references(const CompiledScenario& compiled);

/// Position and yaw of each reference at the present state, four values each; the first values
/// after a reset.
std::vector<double> reference_places(const Simulation& simulation,
                                     const std::vector<FlownReference>& references);

/// What an episode has of one reference. NaN where nothing was counted.
struct ReferenceError {
  double rms[3] = {};      ///< by axis of W [m]
  double total = 0.0;      ///< root of the mean squared distance [m]
  double max = 0.0;        ///< [m]
  double yaw = 0.0;        ///< RMS [rad]
  double effort = 0.0;     ///< sum of the rotors' cubed speeds over that in hover, mean
  double saturated = 0.0;  ///< share of the steps in which a rotor's command is at a limit
  std::vector<double> limited = {};  ///< of each LawLimit: share of the steps in which it cuts
};

/// Adds up errors over an episode.
class ReferenceErrors {
 public:
  explicit ReferenceErrors(const CompiledScenario& compiled);

  /// Takes in the state after a step.
  void add(const Simulation& simulation);
  std::vector<ReferenceError> errors() const;

 private:
  struct Sum {
    double square[3] = {}, max = 0.0, yaw = 0.0, effort = 0.0;
    std::size_t saturated = 0, count = 0;
    std::vector<std::size_t> limited = {};  ///< steps, of each LawLimit
  };
  void add_effort(const Simulation& simulation, const FlownReference& reference, Sum& sum) const;

  const CompiledScenario& compiled_;
  std::vector<FlownReference> references_;
  std::vector<Sum> sums_;
  std::vector<double> hover_speed_;  ///< of each reference's robot [rad/s]
};

/// A row for each episode and reference. Empty without references.
/// @param episodes  the errors of each
std::string reference_table(const CompiledScenario& compiled,
                            const std::vector<std::vector<ReferenceError>>& episodes);

}  // namespace skybody
