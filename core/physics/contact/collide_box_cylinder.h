// Contact of a box and a cylinder. On double and packs.
//
// Seen along the cylinder's axis, a box is a set of corners and edges and the cylinder is a disc.
// The point of an edge closest to the axis has a closed form. It is the deepest point, as long as
// no way out over the cylinder's ends is shorter. Otherwise the deepest point is searched along the
// edge, and points of the cylinder's ends may be in the box.
#pragma once

#include "core/physics/contact/collide_points.h"

namespace skybody {

/// The corners of a box in the frame of a cylinder.
template <class Real>
struct CornersAboutAxis {
  Vec3<Real> edges[3];    ///< along the box's axes, full length, cylinder's axes [m]
  Real x[8], y[8], z[8];  ///< of the corners, in the order of the box's form [m]
  Real square[8];         ///< squared distances from the axis [m^2]

  SKYBODY_INLINE CornersAboutAxis(const PlacedShape<Real>& box, const PlacedShape<Real>& cylinder) {
    const Vec3<Real> center = cylinder.to_local(box.position);
    const Real half[3] = {box.half.x, box.half.y, box.half.z};
    for (int k = 0; k < 3; ++k) {
      edges[k] = transpose_times(cylinder.axes, box.axes.column(k)) * (2.0 * half[k]);
    }
    const Vec3<Real> first = center - (edges[0] + edges[1] + edges[2]) * Real(0.5);
    for (int corner = 0; corner < 8; ++corner) {
      Vec3<Real> at = first;
      for (int k = 0; k < 3; ++k) {
        if ((corner >> k & 1) != 0) at += edges[k];
      }
      x[corner] = at.x;
      y[corner] = at.y;
      z[corner] = at.z;
      square[corner] = at.x * at.x + at.y * at.y;
    }
  }
};

/// Adds the contact points of a box and a cylinder. Refers to its arguments.
template <class Real>
class BoxAndCylinder {
 public:
  /// @param sign  1: the box is the first shape; -1: the cylinder is
  SKYBODY_INLINE BoxAndCylinder(const ContactShape& box_model, const PlacedShape<Real>& box,
                                const PlacedShape<Real>& cylinder, double sign)
      : model_(box_model),
        box_(box),
        cylinder_(cylinder),
        sign_(sign),
        corners_(box, cylinder),
        disc_(cylinder.half.x * cylinder.half.x) {}

  /// @param cylinder_model  the cylinder's shape
  SKYBODY_INLINE void collide(const ContactShape& cylinder_model, const MaskOf<Real>& is_close,
                              Manifold<Real>& out) {
    const auto acts =
        logical_and(is_close, logical_and(box_.rounding > kNoShape, cylinder_.rounding > kNoShape));
    const auto is_side = logical_and(acts, is_at_side());
    const auto is_end = logical_and(acts, logical_not(is_side));
    add_corners(acts, out);
    add_edges(is_side, is_end, out);
    if (!none(is_end)) add_points_of_ends(cylinder_model, is_end, out);
  }

 private:
  /// Whether all ways out over the ends are longer than any over the side.
  SKYBODY_INLINE MaskOf<Real> is_at_side() const {
    Real highest(0.0), sum_x(0.0), sum_y(0.0);
    for (int k = 0; k < 8; ++k) {
      highest = max(highest, abs(corners_.z[k]));
      sum_x += corners_.x[k];
      sum_y += corners_.y[k];
    }
    // Its closest approach to the axis, in the direction of its centre.
    const Real scale = 1.0 / max(sqrt(sum_x * sum_x + sum_y * sum_y), Real(1e-12));
    Real nearest(kInfinity);
    for (int k = 0; k < 8; ++k) {
      nearest = min(nearest, (corners_.x[k] * sum_x + corners_.y[k] * sum_y) * scale);
    }
    return cylinder_.half.z - highest > cylinder_.half.x - max(nearest, Real(0.0));
  }

  SKYBODY_INLINE void add_corners(const MaskOf<Real>& acts, Manifold<Real>& out) {
#pragma GCC unroll 1
    for (int k = 0; k < 8; ++k) {
      depth_[k] = Real(0.0);
      const auto is_in = logical_and(
          acts, logical_and(corners_.square[k] < disc_, abs(corners_.z[k]) < cylinder_.half.z));
      if (none(is_in)) continue;
      const SurfaceDistance<Real> d = cylinder_distance(
          cylinder_.half.x, cylinder_.half.z, {corners_.x[k], corners_.y[k], corners_.z[k]});
      depth_[k] = select(is_in, -d.distance, Real(0.0));
      out.add(box_.place(model_.form->places[static_cast<std::size_t>(k)]),
              cylinder_.axes * d.normal * Real(sign_), depth_[k], bristle_of(model_, k), is_in);
    }
  }

  SKYBODY_INLINE void add_edges(const MaskOf<Real>& is_side, const MaskOf<Real>& is_end,
                                Manifold<Real>& out) const {
    const int count = static_cast<int>(model_.form->edges.size());
#pragma GCC unroll 1
    for (int e = 0; e < count; ++e) {
      const int i = model_.form->edges[static_cast<std::size_t>(e)][0];
      const int k = model_.form->edges[static_cast<std::size_t>(e)][1];
      const Vec3<Real>& along = corners_.edges[k - i == 1 ? 0 : k - i == 2 ? 1 : 2];
      // Its line passes through the disc, and a part of it between the ends.
      const Real square = along.x * along.x + along.y * along.y;
      const Real moment = corners_.x[i] * along.y - corners_.y[i] * along.x;
      const auto passes = logical_and(
          moment * moment <= disc_ * square,
          min(abs(corners_.z[i]), abs(corners_.z[k])) < cylinder_.half.z + abs(along.z));
      const auto at_side = logical_and(is_side, passes), at_end = logical_and(is_end, passes);
      if (!none(at_side)) add_edge_at_side(e, i, k, along, square, at_side, out);
      if (!none(at_end)) add_edge_at_end(e, i, k, along, at_end, out);
    }
  }

  SKYBODY_INLINE void add_edge_at_side(int e, int i, int k, const Vec3<Real>& along,
                                       const Real& square, const MaskOf<Real>& here,
                                       Manifold<Real>& out) const {
    const Real back = -(corners_.x[i] * along.x + corners_.y[i] * along.y);
    const Real share = back / max(square, Real(1e-30));
    const Vec3<Real> at{corners_.x[i] + along.x * share, corners_.y[i] + along.y * share,
                        corners_.z[i] + along.z * share};
    const Real distance = sqrt(at.x * at.x + at.y * at.y);
    const Real deeper = (cylinder_.half.x - distance) - max(depth_[i], depth_[k]);
    const auto is_between = logical_and(share > 0.0, share < 1.0);
    const auto is_on_axis = distance == 0.0;
    const Real scale = 1.0 / select(is_on_axis, Real(1.0), distance);
    const Vec3<Real> normal{select(is_on_axis, Real(1.0), at.x * scale), at.y * scale, Real(0.0)};
    out.add(cylinder_.position + cylinder_.axes * at, cylinder_.axes * normal * Real(sign_), deeper,
            bristle_of(model_, model_.form->point_count + e),
            logical_and(here, logical_and(is_between, deeper > 0.0)));
  }

  SKYBODY_INLINE void add_edge_at_end(int e, int i, int k, const Vec3<Real>& along,
                                      const MaskOf<Real>& here, Manifold<Real>& out) const {
    const Vec3<Real> start{corners_.x[i], corners_.y[i], corners_.z[i]};
    const EdgeDepth<Real> d = edge_depth(cylinder_, start, start + along);
    const Real deeper = -d.distance - max(depth_[i], depth_[k]);
    out.add(cylinder_.position + cylinder_.axes * (start + along * d.share),
            cylinder_.axes * d.normal * Real(sign_), deeper,
            bristle_of(model_, model_.form->point_count + e),
            logical_and(here, logical_and(d.is_between, deeper > 0.0)));
  }

  SKYBODY_INLINE void add_points_of_ends(const ContactShape& model, const MaskOf<Real>& is_end,
                                         Manifold<Real>& out) const {
#pragma GCC unroll 1
    for (int k = 0; k < model.form->point_count; ++k) {
      const Vec3<Real> p = cylinder_.place(model.form->places[static_cast<std::size_t>(k)]);
      const Vec3<Real> local = box_.to_local(p);
      const auto is_in =
          logical_and(logical_and(is_end, abs(local.x) < box_.half.x),
                      logical_and(abs(local.y) < box_.half.y, abs(local.z) < box_.half.z));
      if (none(is_in)) continue;
      const SurfaceDistance<Real> d = box_distance(box_.half, local);
      out.add(p, box_.axes * d.normal * Real(-sign_), -d.distance, bristle_of(model, k), is_in);
    }
    add_rims(model, cylinder_, box_, -sign_, is_end, out);
  }

  const ContactShape& model_;
  const PlacedShape<Real>&box_, &cylinder_;
  double sign_;
  CornersAboutAxis<Real> corners_;
  Real disc_;      ///< the cylinder's squared radius [m^2]
  Real depth_[8];  ///< of the corners [m]
};

}  // namespace skybody
