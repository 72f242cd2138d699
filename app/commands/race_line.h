// A fast line through gates, found by sampling.
//
// The line is the minimum-snap path (plugins/reference/spline.h) from rest to rest through one
// point in each gate. The duration of each piece and the position of each point in its gate are
// sampled: an evolution strategy with one parent changes them at random and keeps the faster line.
// A line's time is that of the fastest time scale at which the vehicle can fly it
// (controllers/common/feasibility.h), so that every kept line is feasible.
//
// Sources: sampling of points, velocities and times as in A. Romero, R. Penicka and D. Scaramuzza,
// Time-optimal online replanning for agile quadrotor flight, RA-L 2022, section IV, with
// minimum-snap splines in place of point masses; the rule for the step size: I. Rechenberg,
// Evolutionsstrategie, 1973.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "controllers/common/feasibility.h"
#include "plugins/reference/spline.h"

namespace skybody {

/// A gate: an opening to be passed along its direction.
struct RaceGate {
  Vec3<double> position;   ///< of the centre, W [m]
  Vec3<double> direction;  ///< unit vector; zero: the line passes the centre in any direction
  double reach = 0.0;      ///< largest distance from the centre [m]
};

/// The task: a start, gates and a finish.
struct RaceCourse {
  Vec3<double> start;  ///< W [m], at rest
  std::vector<RaceGate> gates;
  Vec3<double> finish;  ///< W [m], at rest
};

/// A feasible line.
struct RaceLine {
  reference::Spline spline;
  double peak_speed = 0.0;  ///< [m/s]
  double first_time =
      0.0;  ///< time of the initial guess, whose durations are in proportion to distances [s]
};

/// @param samples  number of lines tried
/// @param seed     of the samples: equal seeds, equal lines
/// @param tell     called after each sample with its number and the best time so far [s]; false
///        ends the search
/// @throws Error if the vehicle cannot fly the course at any pace
RaceLine plan_race_line(const RaceCourse& course, const control::FlightEnvelope& envelope,
                        int samples, std::uint64_t seed,
                        const std::function<bool(int, double)>& tell);

}  // namespace skybody
