// Distances from height fields by functions of their own: for each width of packs there is one,
// which all that asks for distances calls (the code is long).
#pragma once

#include "core/base/pack.h"
#include "core/model/height_field.h"
#include "core/physics/shapes/surface_distance.h"

namespace skybody {

/// What to find the distance of, and the answer.
template <class Real>
struct HeightFieldCall {
  const HeightField& field;
  Real half_x, half_y;  ///< half its size [m]
  double reach;         ///< see height_field_distance.h [m]
  Vec3<Real> point;     ///< in the field's frame [m]
  SurfaceDistance<Real> out;
};

/// Finds a distance. @param call  a HeightFieldCall of the width's type of number
using HeightFieldFunction = void(void* call);

/// @param lanes  1: of doubles; else of packs
HeightFieldFunction* height_field_function(int lanes);

/// @param reach  distances of up to so much are exact [m]
template <class Real>
SKYBODY_INLINE SurfaceDistance<Real> distance_from_heights(const HeightField& field,
                                                           const Real& half_x, const Real& half_y,
                                                           double reach, const Vec3<Real>& point) {
  HeightFieldCall<Real> call{field, half_x, half_y, reach, point, {}};
  height_field_function(kLanesOf<Real>)(&call);
  return call.out;
}

}  // namespace skybody
