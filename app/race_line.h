// A quick line through gates, found by sampling.
//
// The line is the path of least snap (plugins/reference/spline.h) from rest to rest through one
// point in each gate. How long each piece takes and where in its gate each point lies are sampled:
// an evolution strategy with one parent changes them at random and keeps what is quicker. A line's
// time is that of its fastest time scale at which the vehicle can fly it
// (controllers/common/feasibility.h), so that every line that is kept can be flown.
//
// Sources: sampling of points, velocities and times as in A. Romero, R. Penicka and D. Scaramuzza,
// Time-optimal online replanning for agile quadrotor flight, RA-L 2022, section IV, with splines of
// least snap in place of point masses; the rule for the step size: I. Rechenberg,
// Evolutionsstrategie, 1973.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "controllers/common/feasibility.h"
#include "plugins/reference/spline.h"

namespace skybody {

/// A gate: an opening that is passed along its direction.
struct RaceGate {
  Vec3<double> position;   ///< of the middle, W [m]
  Vec3<double> direction;  ///< unit vector; zero: the gate is passed in its middle, from anywhere
  double reach = 0.0;      ///< how far from the middle it may be passed [m]
};

/// What is to be flown.
struct RaceCourse {
  Vec3<double> start;  ///< W [m], at rest
  std::vector<RaceGate> gates;
  Vec3<double> finish;  ///< W [m], at rest
};

/// A line that can be flown.
struct RaceLine {
  reference::Spline spline;
  double peak_speed = 0.0;  ///< [m/s]
  double first_time = 0.0;  ///< of the first guess, with times by distance [s]
};

/// @param samples  lines that are tried
/// @param seed     of the samples: equal seeds, equal lines
/// @param tell     called after each sample with its number and the best time so far [s]; false
/// ends
///                 the search
/// @throws Error where the vehicle cannot fly the course at any pace
RaceLine plan_race_line(const RaceCourse& course, const control::FlightEnvelope& envelope,
                        int samples, std::uint64_t seed,
                        const std::function<bool(int, double)>& tell);

}  // namespace skybody
