// Distance of a point from the surface of a height field: exact, to the nearest point of its
// triangles and of the walls at its four sides. On double and packs. Points and normals are in the
// field's frame.
//
// Algorithm: the point straight below or above gives an upper bound of the distance. Only cells
// within this bound can contain the nearest point; all of them are tested. Close to the surface
// these are one to four cells. Lanes test different cells: each reads heights by its own indices.
// Cells that a lane does not need leave its result unchanged, so each lane has the same bits as
// when computed alone.
#pragma once

#include "core/model/height_field.h"
#include "core/physics/shapes/surface_distance.h"

namespace skybody {

/// The grid of a height field whose size may differ between lanes.
template <class Real>
struct HeightGrid {
  const HeightField& field;
  Real half_x, half_y;  ///< half the field's size [m]
  Real step_x, step_y;  ///< size of a cell [m]

  SKYBODY_INLINE HeightGrid(const HeightField& f, const Real& x, const Real& y)
      : field(f),
        half_x(x),
        half_y(y),
        step_x(x * (2.0 / (f.columns() - 1))),
        step_y(y * (2.0 / (f.rows() - 1))) {}

  /// The height at a corner of cells. @param column, row  whole numbers within the grid
  SKYBODY_INLINE Real height(const Real& column, const Real& row) const {
    const Real place = row * static_cast<double>(field.columns()) + column;
    std::uint64_t places[kLanesOf<Real>];
    double found[kLanesOf<Real>];
    store_words(places, to_word(place));
    for (int i = 0; i < kLanesOf<Real>; ++i) found[i] = field.heights()[places[i]];
    return load_lanes<Real>(found);
  }
  /// Position of a corner.
  SKYBODY_INLINE Vec3<Real> corner(const Real& column, const Real& row) const {
    return {column * step_x - half_x, row * step_y - half_y, height(column, row)};
  }
  /// Index of the cell that contains a coordinate, or of the nearest one; NaN counts as 0.
  /// @param count  number of corners along it
  static SKYBODY_INLINE Real cell(const Real& x, const Real& half, const Real& step, int count) {
    return floor(within((x + half) / step, count - 2.0));
  }
  SKYBODY_INLINE Real cell_x(const Real& x) const {
    return cell(x, half_x, step_x, field.columns());
  }
  SKYBODY_INLINE Real cell_y(const Real& y) const { return cell(y, half_y, step_y, field.rows()); }

  /// Clamps x to [0, most]; NaN counts as 0.
  static SKYBODY_INLINE Real within(const Real& x, double most) {
    const Real positive = select(x > 0.0, x, Real(0.0));
    return select(positive < most, positive, Real(most));
  }
};

/// The surface straight above or below a point within the field's area.
template <class Real>
struct HeightBelow {
  Real height;      ///< [m]
  Vec3<Real> face;  ///< normal of the triangle there, unit
};

template <class Real>
SKYBODY_INLINE HeightBelow<Real> height_below(const HeightGrid<Real>& grid, const Real& x,
                                              const Real& y) {
  const Real column = grid.cell_x(x), row = grid.cell_y(y);
  const Real u = HeightGrid<Real>::within((x + grid.half_x) / grid.step_x - column, 1.0);
  const Real v = HeightGrid<Real>::within((y + grid.half_y) / grid.step_y - row, 1.0);
  const Real low = grid.height(column, row), high = grid.height(column + 1.0, row + 1.0);
  const auto is_right = u > v;  // of the cell's diagonal
  const Real aside =
      grid.height(select(is_right, column + 1.0, column), select(is_right, row, row + 1.0));
  const Real along_x = select(is_right, aside - low, high - aside);
  const Real along_y = select(is_right, high - aside, aside - low);
  const Vec3<Real> face{-along_x / grid.step_x, -along_y / grid.step_y, Real(1.0)};
  return {(low + along_x * u) + along_y * v, face * (1.0 / norm(face))};
}

namespace detail {

/// The shortest vector from a surface to a point, among those tested.
template <class Real>
struct ShortestWay {
  Vec3<Real> way;  ///< from the surface to the point [m]
  Real squared;    ///< its length squared

  SKYBODY_INLINE void take(const Vec3<Real>& other, const MaskOf<Real>& counts) {
    const Real length = dot(other, other);
    const auto is_less = logical_and(counts, length < squared);
    way = select(is_less, other, way);
    squared = select(is_less, length, squared);
  }
};

/// Vector to a point from the nearest point of a line segment.
/// @param p  relative to the segment's start @param along  from its start to its end, not 0
template <class Real>
SKYBODY_INLINE Vec3<Real> way_from_line(const Vec3<Real>& p, const Vec3<Real>& along) {
  const Real share = clamp(dot(p, along) / dot(along, along), Real(0.0), Real(1.0));
  return p - along * share;
}

/// Tests the two triangles of a cell and their five edges.
/// @param p  relative to the cell's corner of least x and y
/// @param a, b, c  the cell's corners of greater x, of greater x and y, and of greater y, relative
/// to the same corner
template <class Real>
SKYBODY_INLINE void take_cell(const Vec3<Real>& p, const Vec3<Real>& a, const Vec3<Real>& b,
                              const Vec3<Real>& c, const MaskOf<Real>& counts,
                              ShortestWay<Real>& shortest) {
  shortest.take(way_from_line(p, a), counts);
  shortest.take(way_from_line(p, b), counts);
  shortest.take(way_from_line(p, c), counts);
  shortest.take(way_from_line(p - a, b - a), counts);
  shortest.take(way_from_line(p - c, b - c), counts);
  const auto take_face = [&](const Vec3<Real>& normal, bool is_right) SKYBODY_INLINE_LAMBDA {
    const Vec3<Real> way = normal * (dot(normal, p) / dot(normal, normal));
    const Vec3<Real> foot = p - way;
    const Real u = foot.x / b.x, v = foot.y / b.y;
    const Real& greater = is_right ? u : v;
    const Real& less = is_right ? v : u;
    const auto is_on_it = logical_and(logical_and(less >= 0.0, greater <= 1.0), greater >= less);
    shortest.take(way, logical_and(counts, is_on_it));
  };
  take_face(cross(a, b), true);
  take_face(cross(b, c), false);
}

/// Squared distance of a point from the bounding box of a cell.
template <class Real>
SKYBODY_INLINE Real squared_from_box(const Vec3<Real>& p, const Vec3<Real>* corners) {
  const auto beyond = [](const Real& x, const Real& low, const Real& high) {
    return max(max(low - x, x - high), Real(0.0));
  };
  const Real &a = corners[0].z, &b = corners[1].z, &c = corners[2].z, &d = corners[3].z;
  const Vec3<Real> apart{beyond(p.x, corners[0].x, corners[2].x),
                         beyond(p.y, corners[0].y, corners[2].y),
                         beyond(p.z, min(min(a, b), min(c, d)), max(max(a, b), max(c, d)))};
  return dot(apart, apart);
}

/// Tests all cells within `window` of a point along x and along y.
template <class Real>
SKYBODY_INLINE void take_cells(const HeightGrid<Real>& grid, const Vec3<Real>& p,
                               const Real& window, ShortestWay<Real>& shortest) {
  const Real first_x = grid.cell_x(p.x - window), last_x = grid.cell_x(p.x + window);
  const Real first_y = grid.cell_y(p.y - window), last_y = grid.cell_y(p.y + window);
  Real row = first_y;
  while (any(row <= last_y)) {
    const Real r = min(row, last_y);
    Real column = first_x;
    while (any(column <= last_x)) {
      const Real c = min(column, last_x);
      const Vec3<Real> corners[4] = {grid.corner(c, r), grid.corner(c + 1.0, r),
                                     grid.corner(c + 1.0, r + 1.0), grid.corner(c, r + 1.0)};
      const auto counts = logical_and(logical_and(row <= last_y, column <= last_x),
                                      squared_from_box(p, corners) < shortest.squared);
      if (!none(counts)) {  // most cells are farther away than the point straight below
        take_cell(p - corners[0], corners[1] - corners[0], corners[2] - corners[0],
                  corners[3] - corners[0], counts, shortest);
      }
      column += 1.0;
    }
    row += 1.0;
  }
}

/// Tests the walls at the sides, for points inside the solid.
template <class Real>
SKYBODY_INLINE void take_walls(const HeightGrid<Real>& grid, const Vec3<Real>& p,
                               const MaskOf<Real>& is_inside, ShortestWay<Real>& shortest) {
  const Real zero(0.0);
  const Real x = p.x - copysign(grid.half_x, p.x), y = p.y - copysign(grid.half_y, p.y);
  shortest.take({x, zero, zero}, is_inside);
  shortest.take({zero, y, zero}, is_inside);
}

}  // namespace detail

/// Distance from the solid below the heights, with upright sides and without a bottom.
/// @param reach  distances up to this one are exact [m]; larger ones are never below it, and their
///               normal points straight up or to the side
template <class Real>
SKYBODY_INLINE SurfaceDistance<Real> height_field_distance(const HeightGrid<Real>& grid,
                                                           double reach, const Vec3<Real>& p) {
  const Real x = clamp(p.x, -grid.half_x, grid.half_x), y = clamp(p.y, -grid.half_y, grid.half_y);
  const HeightBelow<Real> below = height_below(grid, x, y);
  const Real gap = p.z - below.height, aside_x = p.x - x, aside_y = p.y - y;
  const auto is_beside = logical_or(aside_x != 0.0, aside_y != 0.0);
  const auto is_below = gap < 0.0;
  const auto is_inside = logical_and(is_below, logical_not(is_beside));
  const auto is_at_wall = logical_and(is_below, is_beside);
  detail::ShortestWay<Real> shortest;
  shortest.way = {aside_x, aside_y, select(is_at_wall, Real(0.0), gap)};
  shortest.squared = dot(shortest.way, shortest.way);
  detail::take_walls(grid, p, is_inside, shortest);
  detail::take_cells(grid, p, min(sqrt(shortest.squared), Real(reach)), shortest);
  const Real length = sqrt(shortest.squared);
  const Real side(select(is_inside, Real(-1.0), Real(1.0)));
  // On the surface the vector is zero and has no direction.
  const auto is_on_it = length < 1e-9;
  const Real safe = select(is_on_it, Real(1.0), length);
  return {length * side, select(is_on_it, below.face, shortest.way * (side / safe))};
}

}  // namespace skybody
