// Contact of two capsules, or of a capsule and a sphere. On double and packs.
//
// A capsule is a line segment with a radius, a sphere a point with a radius. Two of them touch
// where their segments are nearest: at ends of either, or where the segments cross between their
// ends. Parallel segments touch at two ends.
#pragma once

#include "core/physics/contact/collide_points.h"

namespace skybody {

/// Two capsules, or a capsule and a sphere.
constexpr bool are_capsules(ShapeType a, ShapeType b) {
  const bool is_capsule_a = a == ShapeType::kCapsule, is_capsule_b = b == ShapeType::kCapsule;
  return (is_capsule_a && is_capsule_b) || (is_capsule_a && b == ShapeType::kSphere) ||
         (is_capsule_b && a == ShapeType::kSphere);
}

/// Adds the ends of `a` that are in `b`.
/// @param is_strict  count only ends beside the segment of `b`: the others belong to b's ends
template <class Real>
SKYBODY_INLINE void add_ends(const ContactShape& model, const PlacedShape<Real>& a,
                             const PlacedShape<Real>& b, double sign, bool is_strict,
                             const MaskOf<Real>& is_close, Real& deepest, Manifold<Real>& out) {
#pragma GCC unroll 1
  for (int k = 0; k < model.form->point_count; ++k) {
    const Vec3<Real> end = a.place(model.form->places[static_cast<std::size_t>(k)]);
    const Vec3<Real> local = b.to_local(end);
    const SurfaceDistance<Real> d = b.distance(local);
    const Real depth = a.rounding - d.distance;
    MaskOf<Real> touches = logical_and(is_close, depth > 0.0);
    if (is_strict) touches &= abs(local.z) < b.half.z;
    deepest = select(touches, max(depth, deepest), deepest);
    const Vec3<Real> way = b.axes * d.normal;
    out.add(end - way * a.rounding, way * Real(sign), depth, bristle_of(model, k), touches);
  }
}

template <class Real>
SKYBODY_INLINE void collide_capsules(const ContactShape& model_a, const PlacedShape<Real>& a,
                                     const ContactShape& model_b, const PlacedShape<Real>& b,
                                     const MaskOf<Real>& is_close, Manifold<Real>& out) {
  Real deepest(0.0);
  // Of a sphere only its centre is needed: it is always the nearest point.
  const bool is_ball_a = model_a.type == ShapeType::kSphere,
             is_ball_b = model_b.type == ShapeType::kSphere;
  if (!is_ball_b) add_ends(model_a, a, b, 1.0, false, is_close, deepest, out);
  if (!is_ball_a) add_ends(model_b, b, a, -1.0, !is_ball_b, is_close, deepest, out);
  if (is_ball_a || is_ball_b) return;
  const Vec3<Real> start = a.place({0.0, 0.0, -1.0}), along = a.place({0.0, 0.0, 1.0}) - start;
  const EdgeDepth<Real> d = edge_depth(b, b.to_local(start), b.to_local(start + along));
  const Vec3<Real> p = start + along * d.share;
  // The depth of the ends is subtracted, so that the force is continuous where the crossing reaches
  // an end.
  const Real depth = (a.rounding - d.distance) - deepest;
  const auto is_crossing = logical_and(d.is_between, abs(b.to_local(p).z) < b.half.z);
  const Vec3<Real> way = b.axes * d.normal;
  out.add(p - way * a.rounding, way, depth, bristle_of(model_a, model_a.form->point_count),
          logical_and(is_close, logical_and(is_crossing, depth > 0.0)));
}

}  // namespace skybody
