// Contact of a shape with a plane or a height field. On double and packs.
//
// A plane has contact points only with points of the shape: corners, ends, centres, rims. A height
// field has three kinds of contact points:
// - Points of the shape, by the shortest way out.
// - Edges of the shape that cross ridges of the field. An edge is cut into kEdgeParts parts. Where
//   the distance first falls and then rises along a part, the deepest point is in between.
// - Peaks of the field in faces of the shape: corners of cells that are in the shape, at least as
//   deep as the six neighbouring corners, and not part of a ridge or plain that continues on both
//   sides. The kMostPeaks deepest ones count.
//
// Lanes test different cells of a height field. Each keeps its own peaks, so that its bits are the
// same as when computed alone.
#pragma once

#include "core/physics/contact/collide_points.h"
#include "core/physics/shapes/height_field_distance.h"

namespace skybody {

/// Adds the points of a shape below a plane.
template <class Real>
SKYBODY_INLINE void collide_plane(const ContactShape& model, const PlacedShape<Real>& a,
                                  const PlacedShape<Real>& plane, const MaskOf<Real>& is_close,
                                  Manifold<Real>& out) {
  const Vec3<Real> up = plane.axes.column(2);
  const auto add = [&](const Vec3<Real>& place, int bristle) SKYBODY_INLINE_LAMBDA {
    const Real depth = (a.rounding + plane.rounding) - dot(up, place - plane.position);
    out.add(place - up * a.rounding, up, depth, bristle_of(model, bristle),
            logical_and(is_close, depth > 0.0));
  };
  const auto place = [&](int k) SKYBODY_INLINE_LAMBDA {
    return a.place(model.form->places[static_cast<std::size_t>(k)]);
  };
  if (model.type == ShapeType::kCylinder) {
#pragma GCC unroll 1
    for (int end = 0; end < 2; ++end) {
      const int first = end * kRimPoints;
      const Rim<Real> rim = rim_of(a, end);
      each_rim_place(
          rim, up, [&](int k) SKYBODY_INLINE_LAMBDA { return place(first + k) - rim.middle; },
          [&](const Vec3<Real>& at, int k) SKYBODY_INLINE_LAMBDA { add(at, first + k); });
    }
    return;
  }
#pragma GCC unroll 1
  for (int k = 0; k < model.form->point_count; ++k) add(place(k), k);
}

/// Contact of a shape's edges with the ridges of a height field.
template <class Real>
class FieldEdges {
 public:
  SKYBODY_INLINE FieldEdges(const ContactShape& model, const PlacedShape<Real>& a,
                            const PlacedShape<Real>& field, const MaskOf<Real>& is_close,
                            const Real* ends, Manifold<Real>& out)
      : model_(model),
        a_(a),
        field_(field),
        is_close_(is_close),
        ends_(ends),
        out_(out),
        thickness_(model.form->is_round ? a.half.x + a.rounding : a.rounding) {}

  SKYBODY_INLINE void add_all() {
    const int count = static_cast<int>(model_.form->edges.size());
#pragma GCC unroll 1
    for (int e = 0; e < count; ++e) add(e);
  }

 private:
  static constexpr int kEdgeParts = 8;
  /// Slope of the distance along an edge: smaller slopes count as level.
  static constexpr double kLevelSlope = 1e-6;

  SKYBODY_INLINE void add(int e) {
    const std::array<int, 2>& ends = model_.form->edges[static_cast<std::size_t>(e)];
    const Vec3<Real> start = a_.place(model_.form->places[static_cast<std::size_t>(ends[0])]);
    along_ = a_.place(model_.form->places[static_cast<std::size_t>(ends[1])]) - start;
    start_ = start;
    first_ = ends_[ends[0]];
    last_ = ends_[ends[1]];
    length_ = norm(along_);
    bristle_ = bristle_of(model_, model_.form->point_count + e);
    const auto may = logical_and(is_close_, may_touch(first_, last_, length_));
    if (none(may)) return;
    const SurfaceDistance<Real> middle = sample(kEdgeParts / 2);
    const Real half = 0.5 * length_;
    add_half(0, middle, logical_and(may, may_touch(first_, middle.distance, half)));
    add_half(1, middle, logical_and(may, may_touch(middle.distance, last_, half)));
  }

  /// Along a line the distance changes at most as fast as the position.
  SKYBODY_INLINE MaskOf<Real> may_touch(const Real& one, const Real& other,
                                        const Real& length) const {
    return one + other < length + 2.0 * thickness_;
  }

  SKYBODY_INLINE SurfaceDistance<Real> distance_at(const Real& share) const {
    return field_.distance(field_.to_local(start_ + along_ * share));
  }
  SKYBODY_INLINE SurfaceDistance<Real> sample(int s) const {
    return distance_at(Real(s * (1.0 / kEdgeParts)));
  }

  SKYBODY_INLINE void add_half(int half, const SurfaceDistance<Real>& middle,
                               const MaskOf<Real>& may) {
    if (none(may)) return;
    const int first = half * (kEdgeParts / 2), last = first + kEdgeParts / 2;
    Real falls = slope(half == 0 ? sample(0) : middle);
    Real earlier = half == 0 ? Real(-1.0) : slope(sample(first - 1));
#pragma GCC unroll 1
    for (int s = first; s < last; ++s) {
      const bool is_middle = half == 0 && s + 1 == last;
      const SurfaceDistance<Real> after = is_middle ? middle : sample(s + 1);
      const Real climbs = slope(after);
      const auto is_falling = logical_and(may, falls < -kLevelSlope);
      const auto is_climbing = logical_and(may, climbs > kLevelSlope);
      // At most one of these per lane: one contact point per part.
      found_.counts = MaskOf<Real>(false);
      find_valley(s, logical_and(is_falling, is_climbing));
      if (s + 1 < kEdgeParts) {
        find_end_of_level(s + 1, s, logical_and(is_falling, is_level(climbs)));
      }
      // A single level sample is a ridge, already taken by the previous part.
      const auto was_level = logical_and(is_level(falls), is_level(earlier));
      if (s > 0) find_end_of_level(s, s + 1, logical_and(was_level, is_climbing));
      put_found();
      earlier = falls;
      falls = climbs;
    }
  }

  /// Finds the deepest point within a part.
  SKYBODY_INLINE void find_valley(int s, const MaskOf<Real>& is_valley) {
    if (none(is_valley)) return;
    const double step = 1.0 / kEdgeParts;
    const EdgeDepth<Real> d = edge_depth(field_, field_.to_local(start_ + along_ * Real(s * step)),
                                         field_.to_local(start_ + along_ * Real((s + 1) * step)));
    take((Real(s * 1.0) + d.share) * step, d.distance, d.normal,
         logical_and(is_valley, d.is_between));
  }
  /// Finds the end of ground that is level along the edge: between a level sample and the next one.
  SKYBODY_INLINE void find_end_of_level(int level, int beyond, const MaskOf<Real>& counts) {
    if (none(counts)) return;
    constexpr int kHalvings = 10;
    Real low(level * (1.0 / kEdgeParts)), high(beyond * (1.0 / kEdgeParts));
#pragma GCC unroll 1
    for (int i = 0; i < kHalvings; ++i) {
      const Real middle = 0.5 * (low + high);
      const auto is_on_it = is_level(slope(distance_at(middle)));
      low = select(is_on_it, middle, low);
      high = select(is_on_it, high, middle);
    }
    const SurfaceDistance<Real> d = distance_at(low);
    take(low, d.distance, d.normal, counts);
  }

  /// Rate of change of the distance along the edge.
  SKYBODY_INLINE Real slope(const SurfaceDistance<Real>& d) const {
    return dot(field_.axes * d.normal, along_) / length_;
  }
  static SKYBODY_INLINE MaskOf<Real> is_level(const Real& slope) {
    return abs(slope) <= kLevelSlope;
  }

  SKYBODY_INLINE void take(const Real& share, const Real& distance, const Vec3<Real>& normal,
                           const MaskOf<Real>& counts) {
    found_.share = select(counts, share, found_.share);
    found_.distance = select(counts, distance, found_.distance);
    found_.normal = select(counts, normal, found_.normal);
    found_.counts |= counts;
  }

  SKYBODY_INLINE void put_found() {
    if (none(found_.counts)) return;
    const Real& share = found_.share;
    // Near an end its depth is subtracted, so that an edge and its ends do not both push.
    const auto of_end = [&](const Real& end, const Real& apart) SKYBODY_INLINE_LAMBDA {
      return max(thickness_ - end, Real(0.0)) * max(1.0 - kEdgeParts * apart, Real(0.0));
    };
    const Real taken = max(of_end(first_, share), of_end(last_, 1.0 - share));
    const Real depth = (thickness_ - found_.distance) - taken;
    const Vec3<Real> way = field_.axes * found_.normal;
    out_.add(start_ + along_ * share - way * thickness_, way, depth, bristle_,
             logical_and(found_.counts, depth > 0.0));
  }

  /// Contact of an edge within a part.
  struct Found {
    Real share, distance;  ///< fraction of the edge; distance from the surface [m]
    Vec3<Real> normal;     ///< in the field's frame
    MaskOf<Real> counts;
  };

  const ContactShape& model_;
  const PlacedShape<Real>&a_, &field_;
  const MaskOf<Real>& is_close_;
  const Real* ends_;
  Manifold<Real>& out_;
  Real thickness_;
  // Of the current edge.
  Vec3<Real> start_, along_;
  Real first_, last_;  ///< distances of its ends
  Real length_;
  int bristle_ = -1;
  Found found_{};  // of the current part
};

/// Peaks of a height field in the faces of a shape.
template <class Real>
class FieldPeaks {
 public:
  SKYBODY_INLINE FieldPeaks(const ContactShape& model, const PlacedShape<Real>& a,
                            const PlacedShape<Real>& field, const MaskOf<Real>& is_close)
      : model_(model),
        a_(a),
        field_(field),
        is_close_(is_close),
        grid_(*field.heights.field, field.half.x, field.half.y),
        center_(field.to_local(a.position)) {
    const Vec3<Real> none_yet{Real(0.0), Real(0.0), Real(0.0)};
    for (Peak& peak : peaks_) peak = {none_yet, none_yet, Real(0.0)};
  }

  SKYBODY_INLINE void add_all(Manifold<Real>& out) {
    find_all();
    for (const Peak& peak : peaks_) {
      out.add(peak.point, peak.way, peak.depth, -1, peak.depth > 0.0);
    }
  }

 private:
  static constexpr int kMostPeaks = 8;
  static constexpr double kLevel = 1e-9;  ///< heights that differ by less are equal [m]

  struct Peak {
    Vec3<Real> point;  ///< W
    Vec3<Real> way;    ///< push direction on the shape, W
    Real depth;        ///< 0: no peak [m]
  };

  SKYBODY_INLINE void find_all() {
    const Real first_x = grid_.cell_x(center_.x - model_.reach),
               last_x = grid_.cell_x(center_.x + model_.reach) + 1.0,
               first_y = grid_.cell_y(center_.y - model_.reach),
               last_y = grid_.cell_y(center_.y + model_.reach) + 1.0;
    Real row = first_y;
    while (any(row <= last_y)) {
      Real column = first_x;
      while (any(column <= last_x)) {
        find(min(column, last_x), min(row, last_y),
             logical_and(is_close_, logical_and(row <= last_y, column <= last_x)));
        column += 1.0;
      }
      row += 1.0;
    }
  }

  SKYBODY_INLINE void find(const Real& column, const Real& row, const MaskOf<Real>& counts) {
    const Vec3<Real> corner = grid_.corner(column, row), apart = corner - center_;
    const auto is_near = logical_and(counts, dot(apart, apart) < model_.reach * model_.reach);
    if (none(is_near)) return;
    const SurfaceDistance<Real> d = a_.distance(to_solid(corner));
    const Real depth = -d.distance;
    const Vec3<Real> way = a_.axes * -d.normal;
    MaskOf<Real> is_in = logical_and(is_near, depth > 0.0);
    // No shape is pushed down into the field.
    is_in &= dot(way, field_.axes.column(2)) > 0.0;
    // The axis of a cylinder is handled as an edge; its ends are faces.
    if (model_.type == ShapeType::kCylinder) is_in &= abs(d.normal.z) > 0.5;
    if (none(is_in)) return;
    for (int k = 0; k < 3; ++k) {
      constexpr double kWays[3][2] = {{1, 0}, {0, 1}, {1, 1}};
      const Real after = depth_at(column + kWays[k][0], row + kWays[k][1]);
      const Real before = depth_at(column - kWays[k][0], row - kWays[k][1]);
      is_in &= depth - max(before, after) >= -kLevel;
      is_in &= depth - min(before, after) > kLevel;
    }
    keep({field_.position + field_.axes * corner, way, depth}, is_in);
  }

  /// Depth of a corner in the shape; -kLargest beyond the grid.
  SKYBODY_INLINE Real depth_at(const Real& column, const Real& row) const {
    const double most_column = grid_.field.columns() - 1.0, most_row = grid_.field.rows() - 1.0;
    const Real c = HeightGrid<Real>::within(column, most_column);
    const Real r = HeightGrid<Real>::within(row, most_row);
    const auto is_on_it = logical_and(c == column, r == row);
    const Real depth = -a_.distance(to_solid(grid_.corner(c, r))).distance;
    return select(is_on_it, depth, Real(-kLargest));
  }
  SKYBODY_INLINE Vec3<Real> to_solid(const Vec3<Real>& corner) const {
    return a_.to_local(field_.position + field_.axes * corner);
  }

  /// Replaces the shallowest peak, if this one is deeper.
  SKYBODY_INLINE void keep(const Peak& peak, const MaskOf<Real>& is_one) {
    Real least = peaks_[0].depth, place(0.0);
    for (int k = 1; k < kMostPeaks; ++k) {
      const auto is_less = peaks_[k].depth < least;
      least = select(is_less, peaks_[k].depth, least);
      place = select(is_less, Real(k * 1.0), place);
    }
    const auto is_deeper = logical_and(is_one, peak.depth > least);
    if (none(is_deeper)) return;
    for (int k = 0; k < kMostPeaks; ++k) {
      const auto is_here = logical_and(is_deeper, place == Real(k * 1.0));
      Peak& old = peaks_[k];
      old.point = select(is_here, peak.point, old.point);
      old.way = select(is_here, peak.way, old.way);
      old.depth = select(is_here, peak.depth, old.depth);
    }
  }

  const ContactShape& model_;
  const PlacedShape<Real>&a_, &field_;
  const MaskOf<Real>& is_close_;
  HeightGrid<Real> grid_;
  Vec3<Real> center_;  ///< of the shape, in the field's frame
  Peak peaks_[kMostPeaks];
};

template <class Real>
SKYBODY_INLINE void collide_height_field(const ContactShape& model, const PlacedShape<Real>& a,
                                         const PlacedShape<Real>& field,
                                         const MaskOf<Real>& is_close, Manifold<Real>& out) {
  const auto is_there = logical_and(is_close, field.rounding > kNoShape);
  if (none(is_there)) return;
  static_assert(kMostCollidePoints >= 8 + 12 * 8 + 8, "corners, parts of edges, peaks");
  Real ends[kMostPlaces];
  add_points(model, a, field, 1.0, is_there, ends, out);
  FieldEdges<Real>(model, a, field, is_there, ends, out).add_all();
  if (model.type == ShapeType::kBox || model.type == ShapeType::kCylinder) {
    FieldPeaks<Real>(model, a, field, is_there).add_all(out);
  }
}

}  // namespace skybody
