// Where the robots of a formation belong, and how far they are from standing there.
#pragma once

#include <skybody/plugin.h>

#include <cstddef>
#include <vector>

namespace skybody {

/// Regular polygon in the horizontal plane about the origin, the first corner along +x,
/// counter-clockwise; from five places on the first one is the centre. Their mean is 0.
/// @param radius  [m]
inline std::vector<Vec3<double>> polygon_places(int count, double radius) {
  constexpr int kCentered = 5;  // places from which on one is the centre
  const int center = count >= kCentered ? 1 : 0;
  std::vector<Vec3<double>> places(static_cast<std::size_t>(count), {0.0, 0.0, 0.0});
  for (int i = center; i < count; ++i) {
    const SinCos<double> angle = sincos(kTwoPi * (i - center) / (count - center));
    places[static_cast<std::size_t>(i)] = {radius * angle.cos, radius * angle.sin, 0.0};
  }
  return places;
}

/// How far any robot is from the closest place, or any place from the closest robot [m].
/// @param robot, place  the i-th of `count`, each about its own mean, from an index
template <class Real, class Robots, class Places>
SKYBODY_INLINE Real hausdorff_distance(int count, const Robots& robot, const Places& place) {
  Real farthest(0.0);
  for (int i = 0; i < count; ++i) {
    const Vec3<Real> own = robot(i);
    Real to_place(kInfinity), to_robot(kInfinity);
    for (int j = 0; j < count; ++j) {
      to_place = min(to_place, squared_norm(own - place(j)));
      to_robot = min(to_robot, squared_norm(robot(j) - place(i)));
    }
    farthest = max(farthest, max(to_place, to_robot));
  }
  return sqrt(farthest);
}

}  // namespace skybody
