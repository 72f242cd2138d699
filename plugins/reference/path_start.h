// Start of a path in an environment: numbers that a reset computes and an episode keeps.
#pragma once

#include "plugins/reference/path_parameters.h"

namespace skybody::reference {

/// A plugin's words of state for a path.
template <class Real>
struct PathStart {
  Real rate;          ///< of a figure's angle [rad/s]
  Vec3<Real> offset;  ///< from the path's beginning to the vehicle at the reset, W [m]
};

/// Call it in reset(). @param position  of the vehicle, W [m]
template <class Real>
SKYBODY_INLINE PathStart<Real> path_start(const PathParameters& parameters, const Path& path,
                                          const EnvView<Real>& env, const Vec3<Real>& position) {
  const DrawnNumbers<Real> read{env};
  PathNumbers<Real> numbers = parameters.numbers<Real>(read);
  if (is_harmonic(path.kind)) numbers.rate = parameters.rate(read, numbers.figure);
  if (path.approach > 0.0) {
    numbers.offset = position - derivative(path.at<2>(numbers, Real(0.0)).point, 0);
  }
  return {numbers.rate, numbers.offset};
}

/// All numbers of the environment's path, for Path::at().
template <class Real>
SKYBODY_INLINE PathNumbers<Real> path_numbers(const PathParameters& parameters,
                                              const EnvView<Real>& env,
                                              const PathStart<Real>& start) {
  PathNumbers<Real> numbers = parameters.numbers<Real>(DrawnNumbers<Real>{env});
  numbers.rate = start.rate;
  numbers.offset = start.offset;
  return numbers;
}

/// The numbers from the scenario's values, without an approach.
inline PathNumbers<double> nominal_numbers(const PathParameters& parameters, const Path& path) {
  const NominalNumbers read;
  PathNumbers<double> numbers = parameters.numbers<double>(read);
  if (is_harmonic(path.kind)) numbers.rate = parameters.rate(read, numbers.figure);
  return numbers;
}

}  // namespace skybody::reference
