// The bars of a gate.
#pragma once

#include <array>

#include "core/base/math/vec3.h"

namespace skybody {

/// A bar of a gate, in the gate's frame.
struct GateBar {
  Vec3<double> position;  ///< of its centre [m]
  Vec3<double> size;      ///< edge lengths [m]
};

/// Two posts and two beams around the opening.
/// @param size  width (y) and height (z) of the opening, thickness of the bars [m]
inline std::array<GateBar, 4> gate_bars(const Vec3<double>& size) {
  const double width = size.x, height = size.y, thickness = size.z;
  const double aside = 0.5 * (width + thickness), above = 0.5 * (height + thickness);
  const Vec3<double> post{thickness, thickness, height + 2.0 * thickness};
  const Vec3<double> beam{thickness, width, thickness};
  return {{{{0.0, aside, 0.0}, post},
           {{0.0, -aside, 0.0}, post},
           {{0.0, 0.0, above}, beam},
           {{0.0, 0.0, -above}, beam}}};
}

}  // namespace skybody
