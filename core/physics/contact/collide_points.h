// Contact points of one shape with another: its points inside the other shape and its edges across
// it. On double and packs.
#pragma once

#include "core/physics/contact/manifold.h"

namespace skybody {

/// Bristle index of one of a shape's points or edges.
inline int bristle_of(const ContactShape& placed, int place) {
  return placed.bristle < 0 ? -1 : placed.bristle + place;
}

/// @param end  0: the end of lower z, 1: the other one
template <class Real>
SKYBODY_INLINE Rim<Real> rim_of(const PlacedShape<Real>& cylinder, int end) {
  return {cylinder.place({0.0, 0.0, 2.0 * end - 1.0}), cylinder.axes.column(2), cylinder.half.x};
}

/// Adds, for each rim of a cylinder, the point that is deepest along the outward normal at the
/// rim's centre.
template <class Real>
SKYBODY_INLINE void add_rims(const ContactShape& model, const PlacedShape<Real>& a,
                             const PlacedShape<Real>& b, double sign, const MaskOf<Real>& is_close,
                             Manifold<Real>& out) {
#pragma GCC unroll 1
  for (int end = 0; end < 2; ++end) {
    const Rim<Real> rim = rim_of(a, end);
    const Vec3<Real> down = way_down(rim.axis, b.axes * b.distance(b.to_local(rim.middle)).normal);
    const Vec3<Real> p = lowest_place(rim, down, norm(down));
    const SurfaceDistance<Real> d = b.distance(b.to_local(p));
    out.add(p, b.axes * d.normal * Real(sign), -d.distance, bristle_of(model, end * kRimPoints),
            logical_and(is_close, d.distance < 0.0));
  }
}

/// Adds points of `a` in `b`.
/// @param sign  1: the first shape is `a`; -1: it is `b`
/// @param ends  written: distances of all places of a's form
template <class Real>
SKYBODY_INLINE void add_points(const ContactShape& model, const PlacedShape<Real>& a,
                               const PlacedShape<Real>& b, double sign,
                               const MaskOf<Real>& is_close, Real* ends, Manifold<Real>& out) {
  const int count = static_cast<int>(model.form->places.size());
#pragma GCC unroll 1
  for (int k = 0; k < count; ++k) {
    const Vec3<Real> p = a.place(model.form->places[static_cast<std::size_t>(k)]);
    const SurfaceDistance<Real> d = b.distance(b.to_local(p));
    ends[k] = d.distance;
    if (k >= model.form->point_count) continue;
    const Vec3<Real> way = b.axes * d.normal;
    const Real depth = a.rounding - d.distance;
    out.add(p - way * a.rounding, way * Real(sign), depth, bristle_of(model, k),
            logical_and(is_close, depth > 0.0));
  }
  if (model.type == ShapeType::kCylinder) add_rims(model, a, b, sign, is_close, out);
}

/// Adds edges of `a` across `b`. The depth of the deeper end is subtracted, so that an edge and its
/// ends do not both push.
template <class Real>
SKYBODY_INLINE void add_edges(const ContactShape& model, const PlacedShape<Real>& a,
                              const PlacedShape<Real>& b, double sign, const MaskOf<Real>& is_close,
                              const Real* ends, Manifold<Real>& out) {
  const ContactForm& form = *model.form;
  const Real thickness = form.is_round ? a.half.x + a.rounding : a.rounding;
  const int count = static_cast<int>(form.edges.size());
#pragma GCC unroll 1
  for (int e = 0; e < count; ++e) {
    const int i = form.edges[static_cast<std::size_t>(e)][0];
    const int k = form.edges[static_cast<std::size_t>(e)][1];
    const Vec3<Real> start = a.place(form.places[static_cast<std::size_t>(i)]);
    const Vec3<Real> along = a.place(form.places[static_cast<std::size_t>(k)]) - start;
    // Along it the distance changes at most as fast as the position.
    const Real nearest = thickness * 2.0 - ends[i] - ends[k];
    const auto may =
        logical_and(is_close, logical_or(nearest > 0.0, dot(along, along) > nearest * nearest));
    if (none(may)) continue;
    const EdgeDepth<Real> d = edge_depth(b, b.to_local(start), b.to_local(start + along));
    const Real at_ends = max(thickness - min(ends[i], ends[k]), Real(0.0));
    const Real depth = (thickness - d.distance) - at_ends;
    const Vec3<Real> way = b.axes * d.normal;
    out.add(start + along * d.share - way * thickness, way * Real(sign), depth,
            bristle_of(model, form.point_count + e),
            logical_and(may, logical_and(d.is_between, depth > 0.0)));
  }
}

}  // namespace skybody
