// A box that touches the side of a cylinder, in closed form. On double and packs.
//
// Seen along the cylinder's axis a box is a set of corners and edges, and the cylinder a disc: a
// corner is in by what its distance from the axis is less than the radius; an edge is deepest where
// it passes the axis most closely, and counts for what it is in deeper than its corners are. That
// is so as long as no way out over the cylinder's ends is shorter.
#pragma once

#include "core/physics/contact/manifold.h"

namespace skybody {

/// The corners of a box about the axis of a cylinder.
template <class Real>
struct CornersAboutAxis {
  Vec3<Real> edges[3];                 ///< along the box's axes, whole, cylinder's axes [m]
  Real x[8], y[8], z[8];               ///< of the corners, in the order of the box's form [m]
  Real square[8];                      ///< squared distances from the axis [m^2]

  SKYBODY_INLINE CornersAboutAxis(const Solid<Real>& box, const Solid<Real>& cylinder) {
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

/// The way from a cylinder's axis to a point beside it, W; x of the cylinder on the axis.
template <class Real>
SKYBODY_INLINE Vec3<Real> way_from_axis(const Solid<Real>& cylinder, const Real& x, const Real& y,
                                        const Real& distance) {
  const auto is_on_axis = distance == 0.0;
  const Real scale = 1.0 / select(is_on_axis, Real(1.0), distance);
  return cylinder.axes *
         Vec3<Real>{select(is_on_axis, Real(1.0), x * scale), y * scale, Real(0.0)};
}

/// Adds the places of a box at the side of a cylinder.
/// @param model  of the box
/// @param sign   1: the box is the first solid; -1: the cylinder is
/// @returns lanes of `is_close` that are done with: in others the cylinder's ends may matter
template <class Real>
SKYBODY_INLINE MaskOf<Real> meet_side(const ContactSolid& model, const Solid<Real>& box,
                                      const Solid<Real>& cylinder, double sign,
                                      const MaskOf<Real>& is_close, Manifold<Real>& out) {
  const auto is_there = logical_and(box.rounding > kNoSolid, cylinder.rounding > kNoSolid);
  const CornersAboutAxis<Real> corners(box, cylinder);
  const Real radius = cylinder.half.x, disc = radius * radius;
  Real highest(0.0), sum_x(0.0), sum_y(0.0);
  for (int k = 0; k < 8; ++k) {
    highest = max(highest, abs(corners.z[k]));
    sum_x += corners.x[k];
    sum_y += corners.y[k];
  }
  // What the box reaches towards the axis from its centre is how deep it is in at most.
  const Real off = sqrt(sum_x * sum_x + sum_y * sum_y);
  const Real scale = 1.0 / max(off, Real(1e-12));
  Real nearest(kInfinity);
  for (int k = 0; k < 8; ++k) {
    nearest = min(nearest, (corners.x[k] * sum_x + corners.y[k] * sum_y) * scale);
  }
  const auto is_side =
      logical_and(is_close, cylinder.half.z - highest > radius - max(nearest, Real(0.0)));
  const auto acts = logical_and(is_side, is_there);
  if (none(acts)) return is_side;

  Real depth[8];
#pragma GCC unroll 1
  for (int k = 0; k < 8; ++k) {
    depth[k] = Real(0.0);
    const auto is_in = logical_and(acts, corners.square[k] < disc);
    if (none(is_in)) continue;
    const Real distance = sqrt(corners.square[k]);
    depth[k] = max(radius - distance, Real(0.0));
    const Vec3<Real> way = way_from_axis(cylinder, corners.x[k], corners.y[k], distance);
    out.add(box.place(model.form->places[static_cast<std::size_t>(k)]), way * Real(sign), depth[k],
            bristle_of(model, k), is_in);
  }
  const int count = static_cast<int>(model.form->edges.size());
#pragma GCC unroll 1
  for (int e = 0; e < count; ++e) {
    const int i = model.form->edges[static_cast<std::size_t>(e)][0];
    const int k = model.form->edges[static_cast<std::size_t>(e)][1];
    const Vec3<Real>& along = corners.edges[k - i == 1 ? 0 : k - i == 2 ? 1 : 2];
    const Real square = along.x * along.x + along.y * along.y;
    const Real moment = corners.x[i] * along.y - corners.y[i] * along.x;
    const Real back = -(corners.x[i] * along.x + corners.y[i] * along.y);
    const auto passes = logical_and(logical_and(back > 0.0, back < square),
                                    moment * moment < disc * square);
    const auto here = logical_and(acts, passes);
    if (none(here)) continue;
    const Real share = back / max(square, Real(1e-30));
    const Real px = corners.x[i] + along.x * share, py = corners.y[i] + along.y * share;
    const Real distance = sqrt(px * px + py * py);
    const Real deeper = (radius - distance) - max(depth[i], depth[k]);
    const Vec3<Real> way = way_from_axis(cylinder, px, py, distance);
    const Vec3<Real> at{px, py, corners.z[i] + along.z * share};
    out.add(cylinder.position + cylinder.axes * at, way * Real(sign), deeper,
            bristle_of(model, model.form->point_count + e), logical_and(here, deeper > 0.0));
  }
  return is_side;
}

}  // namespace skybody
