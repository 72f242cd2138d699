// Places of the robots of a formation, and their distance from them.
#pragma once

#include <skybody/plugin.h>

#include <cstddef>
#include <vector>

namespace skybody {

/// Regular polygon in the horizontal plane about the origin, the first corner along +x,
/// counter-clockwise; from five places on the first one is the centre. Their mean is 0.
/// @param radius  [m]
inline std::vector<Vec3<double>> polygon_places(int count, double radius) {
  constexpr int kCentered = 5;  // number of places from which on one is the centre
  const int center = count >= kCentered ? 1 : 0;
  std::vector<Vec3<double>> places(static_cast<std::size_t>(count), {0.0, 0.0, 0.0});
  for (int i = center; i < count; ++i) {
    const SinCos<double> angle = sincos(kTwoPi * (i - center) / (count - center));
    places[static_cast<std::size_t>(i)] = {radius * angle.cos, radius * angle.sin, 0.0};
  }
  return places;
}

}  // namespace skybody
