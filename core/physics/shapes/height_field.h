// Distances from height fields. The code is long, so each width of packs has one function that all
// callers share.
#pragma once

#include "core/base/simd/pack.h"
#include "core/model/height_field.h"
#include "core/physics/shapes/surface_distance.h"

namespace skybody {

/// Arguments and result of a distance query.
template <class Real>
struct HeightFieldCall {
  const HeightField& field;
  Real half_x, half_y;  ///< half its size [m]
  double reach;         ///< see height_field_distance.h [m]
  Vec3<Real> point;     ///< in the field's frame [m]
  SurfaceDistance<Real> out;
};

/// Computes a distance. @param call  a HeightFieldCall with the number type of the width
using HeightFieldFunction = void(void* call);

/// @param lanes  1: doubles; otherwise packs
HeightFieldFunction* height_field_function(int lanes);

/// @param reach  distances up to this one are exact [m]
template <class Real>
SKYBODY_INLINE SurfaceDistance<Real> distance_from_heights(const HeightField& field,
                                                           const Real& half_x, const Real& half_y,
                                                           double reach, const Vec3<Real>& point) {
  HeightFieldCall<Real> call{field, half_x, half_y, reach, point, {}};
  height_field_function(kLanesOf<Real>)(&call);
  return call.out;
}

}  // namespace skybody
