// Hausdorff distance of two sets of points.
#pragma once

#include <skybody/plugin.h>

namespace skybody::task_kit {

namespace detail {

/// The largest squared distance from a point of one set to the closest point of the other.
template <class Real, class From, class To>
SKYBODY_INLINE Real squared_distance_to_set(int count, const From& from, const To& to) {
  Real farthest(0.0);
  for (int i = 0; i < count; ++i) {
    const Vec3<Real> point = from(i);
    Real nearest(kInfinity);
    for (int j = 0; j < count; ++j) nearest = min(nearest, squared_norm(point - to(j)));
    farthest = max(farthest, nearest);
  }
  return farthest;
}

}  // namespace detail

/// Hausdorff distance of two sets: the largest distance from a point of either set to the closest
/// point of the other [m]. For sets of up to 32 points each distance is computed once.
/// @param count   points of either set
/// @param a, b    functions from an index to a point of each set
template <class Real, class A, class B>
SKYBODY_INLINE Real hausdorff_distance(int count, const A& a, const B& b) {
  constexpr int kMost = 32;
  if (count > kMost) {
    return sqrt(max(detail::squared_distance_to_set<Real>(count, a, b),
                    detail::squared_distance_to_set<Real>(count, b, a)));
  }
  Real nearest_of_b[kMost], farthest(0.0);
  for (int j = 0; j < count; ++j) nearest_of_b[j] = Real(kInfinity);
  for (int i = 0; i < count; ++i) {
    const Vec3<Real> point = a(i);
    Real nearest(kInfinity);
    for (int j = 0; j < count; ++j) {
      const Real square = squared_norm(point - b(j));
      nearest = min(nearest, square);
      nearest_of_b[j] = min(nearest_of_b[j], square);
    }
    farthest = max(farthest, nearest);
  }
  for (int j = 0; j < count; ++j) farthest = max(farthest, nearest_of_b[j]);
  return sqrt(farthest);
}

}  // namespace skybody::task_kit
