// Contact points of two shapes: one for each corner of their common volume. On double and packs.
//
// - Two boxes: the axis of least overlap is one of their faces' normals or a product of their edges
//   (S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree", 1996, section 5). It is the normal of all
//   contact points: corners of either box within the other's sides, and intersections of edges of
//   one with the other's sides.
// - Planes and height fields: collide_plane_and_field.h.
// - Two capsules: collide_capsules.h.
// - Other pairs: points inside the other shape, by the shortest way out, and edges across it.
#pragma once

#include "core/physics/contact/collide_box_cylinder.h"
#include "core/physics/contact/collide_capsules.h"
#include "core/physics/contact/collide_plane_and_field.h"

namespace skybody {

/// The axis of least overlap of two boxes.
template <class Real>
struct LeastOverlap {
  Vec3<Real> normal;          ///< unit, W, from the second box to the first
  Real depth;                 ///< [m]; negative: separated
  Real kind;                  ///< 0: a face of the second, 1: of the first, 2: crossing edges
  Vec3<Real> edge_a, edge_b;  ///< directions of the crossing edges, W
};

/// Extent of a box from its centre along a unit vector.
template <class Real>
SKYBODY_INLINE Real reach_along(const PlacedShape<Real>& box, const Vec3<Real>& n) {
  const Vec3<Real> local = transpose_times(box.axes, n);
  return (abs(local.x) * box.half.x + abs(local.y) * box.half.y) + abs(local.z) * box.half.z;
}

template <class Real>
SKYBODY_INLINE LeastOverlap<Real> least_overlap(const PlacedShape<Real>& a,
                                                const PlacedShape<Real>& b) {
  const Vec3<Real> apart = a.position - b.position;
  const Vec3<Real> zero{Real(0.0), Real(0.0), Real(0.0)};
  LeastOverlap<Real> least{zero, Real(kInfinity), Real(0.0), zero, zero};
#pragma GCC unroll 1
  for (int k = 0; k < 15; ++k) {
    // Faces of b, faces of a, products of edges.
    const Vec3<Real> x = k < 6 ? zero : a.axes.column((k - 6) / 3);
    const Vec3<Real> y = k < 6 ? zero : b.axes.column((k - 6) % 3);
    Vec3<Real> n = k < 3 ? b.axes.column(k) : k < 6 ? a.axes.column(k - 3) : cross(x, y);
    const Real length = norm(n);
    const auto is_axis = length > 1e-3;  // otherwise the edges are parallel
    n = n * (1.0 / select(is_axis, length, Real(1.0)));
    const Real along = dot(n, apart);
    const Real depth = reach_along(a, n) + reach_along(b, n) - abs(along);
    // Faces are preferred at about equal depths: they have more contact points.
    const Real most = k < 6 ? least.depth : 0.9 * least.depth - 1e-5;
    const auto is_less = logical_and(is_axis, depth < most);
    least.normal = select(is_less, n * copysign(Real(1.0), along), least.normal);
    least.depth = select(is_less, depth, least.depth);
    least.kind = select(is_less, Real(k < 3 ? 0.0 : k < 6 ? 1.0 : 2.0), least.kind);
    least.edge_a = select(is_less, x, least.edge_a);
    least.edge_b = select(is_less, y, least.edge_b);
  }
  return least;
}

/// The part of a line segment within the sides of a box, that is, without the faces that `normal`
/// belongs to. As fractions of the segment.
template <class Real>
struct LinePart {
  Real first, last;  ///< first > last: none
};
template <class Real>
SKYBODY_INLINE LinePart<Real> within_sides(const PlacedShape<Real>& box, const Vec3<Real>& normal,
                                           const Vec3<Real>& start, const Vec3<Real>& along) {
  const Vec3<Real> n = transpose_times(box.axes, normal), p = box.to_local(start),
                   e = transpose_times(box.axes, along);
  LinePart<Real> part{Real(0.0), Real(1.0)};
  const Real ns[3] = {n.x, n.y, n.z}, ps[3] = {p.x, p.y, p.z}, es[3] = {e.x, e.y, e.z},
             hs[3] = {box.half.x, box.half.y, box.half.z};
  for (int k = 0; k < 3; ++k) {
    const auto is_side = abs(ns[k]) < 0.9;  // the face's own axis has 1
    const auto is_across = abs(es[k]) > 1e-9;
    const Real rate = 1.0 / select(is_across, es[k], Real(1.0));
    const Real one = (-hs[k] - ps[k]) * rate, two = (hs[k] - ps[k]) * rate;
    const auto cuts = logical_and(is_side, is_across);
    part.first = select(cuts, max(part.first, min(one, two)), part.first);
    part.last = select(cuts, min(part.last, max(one, two)), part.last);
    const auto is_out =
        logical_and(logical_and(is_side, logical_not(is_across)), abs(ps[k]) > hs[k]);
    part.last = select(is_out, Real(-1.0), part.last);
  }
  return part;
}

/// Adds corners of `a`, and intersections of its edges with the sides of `b`, below the face of `b`
/// with a given normal.
/// @param out_of_b  the face's normal
/// @param sign      1: the first shape is `a`; -1: it is `b`
template <class Real>
SKYBODY_INLINE void add_face_places(const ContactShape& model, const PlacedShape<Real>& a,
                                    const PlacedShape<Real>& b, const Vec3<Real>& out_of_b,
                                    double sign, const MaskOf<Real>& acts, Manifold<Real>& out) {
  const ContactForm& form = *model.form;
  const Real top = dot(out_of_b, b.position) + reach_along(b, out_of_b);
  const Vec3<Real> way = out_of_b * Real(sign);
  MaskOf<Real> is_done[kMostPlaces];
  for (int k = 0; k < form.point_count; ++k) is_done[k] = MaskOf<Real>(false);
  const int count = static_cast<int>(form.edges.size());
#pragma GCC unroll 1
  for (int e = 0; e < count; ++e) {
    const std::array<int, 2>& ends = form.edges[static_cast<std::size_t>(e)];
    const Vec3<Real> start = a.place(form.places[static_cast<std::size_t>(ends[0])]);
    const Vec3<Real> along = a.place(form.places[static_cast<std::size_t>(ends[1])]) - start;
    const Real depth = top - dot(out_of_b, start), change = -dot(out_of_b, along);
    const auto is_low = logical_and(acts, max(depth, depth + change) > 0.0);
    if (none(is_low)) continue;
    const LinePart<Real> part = within_sides(b, out_of_b, start, along);
    const auto is_over = logical_and(is_low, part.first <= part.last);
    if (none(is_over)) continue;
    for (int end = 0; end < 2; ++end) {
      const Real share = end == 0 ? part.first : part.last;
      const auto is_corner = end == 0 ? share <= 0.0 : share >= 1.0;
      const Real here = depth + change * share;
      const auto touches = logical_and(is_over, here > 0.0);
      const Vec3<Real> p = start + along * share;
      MaskOf<Real>& corner_done = is_done[ends[end]];
      const auto new_corner =
          logical_and(logical_and(touches, is_corner), logical_not(corner_done));
      corner_done |= new_corner;
      out.add(p, way, here, bristle_of(model, ends[end]), new_corner);
      out.add(p, way, here, end == 0 ? bristle_of(model, form.point_count + e) : -1,
              logical_and(touches, logical_not(is_corner)));
    }
  }
}

/// Adds corners of `b` within `a`, straight above a face of `b`.
/// @param out_of_b, sign  as for add_face_places
template <class Real>
SKYBODY_INLINE void add_corners_within(const ContactShape& model_b, const PlacedShape<Real>& a,
                                       const PlacedShape<Real>& b, const Vec3<Real>& out_of_b,
                                       double sign, const MaskOf<Real>& acts, Manifold<Real>& out) {
  const Vec3<Real> e = transpose_times(a.axes, out_of_b);
  const Real es[3] = {e.x, e.y, e.z}, hs[3] = {a.half.x, a.half.y, a.half.z};
  const Real top = reach_along(b, out_of_b);
#pragma GCC unroll 1
  for (int k = 0; k < model_b.form->point_count; ++k) {
    const Vec3<Real> corner = b.place(model_b.form->places[static_cast<std::size_t>(k)]);
    const auto is_top = dot(out_of_b, corner - b.position) > top * (1.0 - 1e-6) - 1e-9;
    const auto may = logical_and(acts, is_top);
    if (none(may)) continue;
    // A line through `a` along the normal: its entry point, below the corner.
    const Vec3<Real> p = a.to_local(corner);
    const Real ps[3] = {p.x, p.y, p.z};
    Real first(-kInfinity), last(kInfinity);
    MaskOf<Real> is_through = may;
    for (int i = 0; i < 3; ++i) {
      const auto is_across = abs(es[i]) > 1e-9;
      const Real rate = 1.0 / select(is_across, es[i], Real(1.0));
      const Real one = (-hs[i] - ps[i]) * rate, two = (hs[i] - ps[i]) * rate;
      first = select(is_across, max(first, min(one, two)), first);
      last = select(is_across, min(last, max(one, two)), last);
      // Strictly: a corner of `a` at the same position is already added.
      is_through &= logical_or(is_across, abs(ps[i]) < hs[i] - 1e-9);
    }
    const auto touches = logical_and(is_through, logical_and(first<-1e-12, last> 0.0));
    out.add(corner, out_of_b * Real(sign), -first, bristle_of(model_b, k), touches);
  }
}

/// Adds the crossing point of the edges of two boxes.
template <class Real>
SKYBODY_INLINE void add_crossing(const ContactShape& model_a, const PlacedShape<Real>& a,
                                 const PlacedShape<Real>& b, const LeastOverlap<Real>& least,
                                 const MaskOf<Real>& acts, Manifold<Real>& out) {
  if (none(acts)) return;
  // The midpoint of each box's edge that is farthest towards the other.
  const auto middle = [&](const PlacedShape<Real>& box, const Vec3<Real>& towards,
                          const Vec3<Real>& edge) SKYBODY_INLINE_LAMBDA {
    const Vec3<Real> n = transpose_times(box.axes, towards), e = transpose_times(box.axes, edge);
    const auto side = [](const Real& way, const Real& half, const Real& along) {
      return select(abs(along) > 0.5, Real(0.0), half * copysign(Real(1.0), way));
    };
    return box.position + box.axes * Vec3<Real>{side(n.x, box.half.x, e.x),
                                                side(n.y, box.half.y, e.y),
                                                side(n.z, box.half.z, e.z)};
  };
  const Vec3<Real> from_a = middle(a, -least.normal, least.edge_a),
                   from_b = middle(b, least.normal, least.edge_b);
  const Real cosine = dot(least.edge_a, least.edge_b);
  const Real sine2 = max(1.0 - cosine * cosine, Real(1e-9));
  const Vec3<Real> gap = from_b - from_a;
  const Real along = (dot(gap, least.edge_a) - cosine * dot(gap, least.edge_b)) / sine2;
  out.add(from_a + least.edge_a * along + least.normal * (0.5 * least.depth), least.normal,
          least.depth, bristle_of(model_a, model_a.form->point_count), acts);
}

template <class Real>
SKYBODY_INLINE void collide_boxes(const ContactShape& model_a, const PlacedShape<Real>& a,
                                  const ContactShape& model_b, const PlacedShape<Real>& b,
                                  const MaskOf<Real>& is_close, Manifold<Real>& out) {
  const auto is_there = logical_and(a.rounding > kNoShape, b.rounding > kNoShape);
  const LeastOverlap<Real> least = least_overlap(a, b);
  const auto acts = logical_and(logical_and(is_close, is_there), least.depth > 0.0);
  if (none(acts)) return;
#pragma GCC unroll 1
  for (int of_a = 0; of_a < 2; ++of_a) {
    const auto here = logical_and(acts, least.kind == Real(of_a));
    if (none(here)) continue;
    const double sign = of_a == 0 ? 1.0 : -1.0;
    const Vec3<Real> out_of_face = least.normal * Real(sign);
    const PlacedShape<Real>&face = of_a == 0 ? b : a, &other = of_a == 0 ? a : b;
    const ContactShape &face_model = of_a == 0 ? model_b : model_a,
                       &other_model = of_a == 0 ? model_a : model_b;
    add_face_places(other_model, other, face, out_of_face, sign, here, out);
    add_corners_within(face_model, other, face, out_of_face, sign, here, out);
  }
  add_crossing(model_a, a, b, least, logical_and(acts, least.kind == Real(2.0)), out);
}

/// Adds the contact points of two shapes.
/// @param is_close  lanes to test
template <class Real>
SKYBODY_INLINE void add_places(const ContactShape& model_a, const PlacedShape<Real>& a,
                               const ContactShape& model_b, const PlacedShape<Real>& b,
                               const MaskOf<Real>& is_close, Manifold<Real>& out) {
  const bool is_box_a = model_a.type == ShapeType::kBox, is_box_b = model_b.type == ShapeType::kBox;
  if (is_box_a && is_box_b) return collide_boxes(model_a, a, model_b, b, is_close, out);
  if (model_b.type == ShapeType::kPlane) return collide_plane(model_a, a, b, is_close, out);
  if (model_b.type == ShapeType::kHeightField) {
    return collide_height_field(model_a, a, b, is_close, out);
  }
  if (are_capsules(model_a.type, model_b.type)) {
    return collide_capsules(model_a, a, model_b, b, is_close, out);
  }
  if (is_box_a && model_b.type == ShapeType::kCylinder) {
    return BoxAndCylinder<Real>(model_a, a, b, 1.0).collide(model_b, is_close, out);
  }
  if (is_box_b && model_a.type == ShapeType::kCylinder) {
    return BoxAndCylinder<Real>(model_b, b, a, -1.0).collide(model_a, is_close, out);
  }
  // Uses the edges of a box, if there is one, otherwise of the first shape. A sphere has one
  // contact point, which is nearest to the other's surface: points of the other shape inside the
  // sphere are not needed.
  const bool is_sphere_a = model_a.type == ShapeType::kSphere,
             is_sphere_b = model_b.type == ShapeType::kSphere;
  const bool by_others_edges = !is_box_a && is_box_b;
  Real ends[2][kMostPlaces];
#pragma GCC unroll 1
  for (int turn = 0; turn < 2; ++turn) {
    const bool is_first = turn == 0;
    if (is_first ? is_sphere_b && !is_sphere_a : is_sphere_a) continue;
    add_points(is_first ? model_a : model_b, is_first ? a : b, is_first ? b : a,
               is_first ? 1.0 : -1.0, is_close, ends[turn], out);
  }
  if (is_sphere_a || is_sphere_b) return;
  const bool is_first = !by_others_edges;
  add_edges(is_first ? model_a : model_b, is_first ? a : b, is_first ? b : a, is_first ? 1.0 : -1.0,
            is_close, ends[is_first ? 0 : 1], out);
}

}  // namespace skybody
