// Where rays enter a shape: w = 1 / t of entry, for the rows of a tile.
//
// A round of radius r about an axis, or about a point: with o the eye from its centre and d the
// direction, both across the axis, and c = |o|^2 - r^2, the roots of c w^2 + 2 (o . d) w + |d|^2
// are
//   w = B +- sqrt(D),   B = -(o . d) / c,   D = (r^2 |d|^2 - |o x d|^2) / c^2
// (identity of Lagrange: no difference of large squares). D < 0 gives NaN, which is never a hit.
#pragma once

#include "render/kernels/kernel_table.h"
#include "render/kernels/lanes.h"

namespace skybody::render::kernels::SKYBODY_KERNEL_SET {

/// Directions (x, y, 1) of some columns of a tile: those of an image's columns and rows.
struct Grid {
  Floats columns;
  const float* rows;

  SKYBODY_RENDER Grid(const TileCall& call, int column)
      : columns(load<Floats>(call.x + column)), rows(call.y) {}
  SKYBODY_RENDER const Floats& x(int) const { return columns; }
  SKYBODY_RENDER float y(int r) const { return rows[r]; }
};

/// The same, one by one.
struct Scattered {
  Floats across[kTileHeight], down[kTileHeight];

  SKYBODY_RENDER Scattered(const TileCall& call, int column) {
    for (int r = 0; r < kTileHeight; ++r) {
      across[r] = load<Floats>(call.x + r * kTileWidth + column);
      down[r] = load<Floats>(call.y + r * kTileWidth + column);
    }
  }
  SKYBODY_RENDER const Floats& x(int r) const { return across[r]; }
  SKYBODY_RENDER const Floats& y(int r) const { return down[r]; }
};

/// A linear function of the directions of row r. In a grid the part of the columns is computed
/// once.
template <class Rays>
struct Along;
template <>
struct Along<Grid> {
  Floats of_columns;
  float slope;
  const float* rows;

  SKYBODY_RENDER Along(const Linear& f, const Grid& rays)
      : of_columns(f.c + f.x * rays.columns), slope(f.y), rows(rays.rows) {}
  SKYBODY_RENDER Floats at(int r) const { return of_columns + slope * rows[r]; }
};
template <>
struct Along<Scattered> {
  const Linear& f;
  const Scattered& rays;

  SKYBODY_RENDER Along(const Linear& function, const Scattered& directions)
      : f(function), rays(directions) {}
  SKYBODY_RENDER Floats at(int r) const { return (f.c + f.x * rays.x(r)) + f.y * rays.y(r); }
};

/// The nearest surface of each pixel of some columns of a tile so far.
template <bool kSurfaces>
struct Nearest {
  Floats w[kTileHeight];
  Ints id[kTileHeight];
  Ints surface[kTileHeight];

  SKYBODY_RENDER void put(int r, Mask hit, const Floats& entry, uint32_t shape_id) {
    w[r] = select(hit, entry, w[r]);
    id[r] = select(hit, ints(static_cast<int32_t>(shape_id)), id[r]);
  }
  SKYBODY_RENDER void put_surface(int r, Mask hit, const Ints& code) {
    if constexpr (kSurfaces) surface[r] = select(hit, code, surface[r]);
  }
};

/// A box from outside of `kPairs` pairs of faces.
template <int kPairs, class Rays, bool kSurfaces>
SKYBODY_RENDER void meet_box(const SeenShape& s, int32_t code, const Rays& rays,
                             Nearest<kSurfaces>& nearest) {
  const Along<Rays> f0(s.f[0], rays), f1(s.f[1], rays), f2(s.f[2], rays);
#pragma GCC unroll 4
  for (int r = 0; r < kTileHeight; ++r) {
    const Floats w0 = f0.at(r), w1 = f1.at(r), w2 = f2.at(r);
    Floats entry = w0, exit = w0 * s.n[0];
    if constexpr (kPairs >= 2) entry = min(entry, w1);
    if constexpr (kPairs == 3) entry = min(entry, w2);
    const Floats exit1 = w1 * s.n[1], exit2 = w2 * s.n[2];
    exit = max(exit, kPairs >= 2 ? exit1 : max(w1, exit1));
    exit = max(exit, kPairs == 3 ? exit2 : max(w2, exit2));
    const Mask hit = at_least(entry, exit) & greater(entry, nearest.w[r]);
    nearest.put(r, hit, entry, s.id);
    if constexpr (kSurfaces) {
      Ints face = ints(code);
      if constexpr (kPairs >= 2) face = select(equal(entry, w1), ints(code + 1), face);
      if constexpr (kPairs == 3) face = select(equal(entry, w2), ints(code + 2), face);
      nearest.put_surface(r, hit, face);
    }
  }
}

template <class Rays, bool kSurfaces>
SKYBODY_RENDER void meet_sphere(const SeenShape& s, int32_t code, const Rays& rays,
                                Nearest<kSurfaces>& nearest) {
  const Along<Rays> middle(s.f[0], rays), across(s.f[1], rays);
  const float k = s.n[0], cy = s.n[1], cz = s.n[2], cx = s.n[3];
#pragma GCC unroll 4
  for (int r = 0; r < kTileHeight; ++r) {
    const Floats aside = cz * rays.x(r) - cx;
    const Floats part = (1.0f + rays.x(r) * rays.x(r)) * k - aside * aside;
    const auto down = cy - cz * rays.y(r);
    const auto rest = rays.y(r) * rays.y(r) * k - down * down;
    const Floats c = across.at(r);
    const Floats w = middle.at(r) + sqrt((part + rest) - c * c);
    const Mask hit = greater(w, nearest.w[r]);
    nearest.put(r, hit, w, s.id);
    nearest.put_surface(r, hit, ints(code));
  }
}

/// A cylinder, or the side of one.
template <Form kForm, class Rays, bool kSurfaces>
SKYBODY_RENDER void meet_cylinder(const SeenShape& s, int32_t code, const Rays& rays,
                                  Nearest<kSurfaces>& nearest) {
  const Along<Rays> middle(s.f[0], rays), gx(s.f[1], rays), gy(s.f[2], rays), across(s.f[3], rays),
      axial(s.f[4], rays);
#pragma GCC unroll 4
  for (int r = 0; r < kTileHeight; ++r) {
    const Floats a = gx.at(r), b = gy.at(r), c = across.at(r), z = axial.at(r);
    const Floats root = sqrt((a * a + b * b) - c * c), mid = middle.at(r);
    const Floats near_side = mid + root;
    Floats entry = near_side;
    Mask hit;
    if constexpr (kForm == Form::kTube) {
      hit = at_least(entry * s.n[1], abs(entry * s.n[0] + z)) & greater(entry, nearest.w[r]);
    } else {
      Floats exit;
      if constexpr (kForm == Form::kCylinderSide) exit = max(max(z, z * s.n[0]), mid - root);
      if constexpr (kForm == Form::kCylinderCap) {
        entry = z;
        exit = max(z * s.n[0], near_side);
      }
      if constexpr (kForm == Form::kCylinderBoth) {
        entry = min(z, near_side);
        exit = max(z * s.n[0], mid - root);
      }
      hit = at_least(entry, exit) & greater(entry, nearest.w[r]);
    }
    nearest.put(r, hit, entry, s.id);
    if constexpr (kSurfaces) {
      Ints face = ints(kForm == Form::kCylinderCap ? code + 1 : code);
      if constexpr (kForm == Form::kCylinderBoth) {
        face = select(equal(entry, z), ints(code + 1), face);
      }
      nearest.put_surface(r, hit, face);
    }
  }
}

template <class Rays, bool kSurfaces>
SKYBODY_RENDER void meet_plane(const SeenShape& s, int32_t code, const Rays& rays,
                               Nearest<kSurfaces>& nearest) {
  const Along<Rays> f(s.f[0], rays);
#pragma GCC unroll 4
  for (int r = 0; r < kTileHeight; ++r) {
    const Floats w = f.at(r);
    const Mask hit = greater(w, nearest.w[r]);
    nearest.put(r, hit, w, s.id);
    nearest.put_surface(r, hit, ints(code));
  }
}

template <class Rays, bool kSurfaces>
SKYBODY_RENDER void meet(const SeenShape& s, int32_t code, const Rays& rays,
                         Nearest<kSurfaces>& nearest) {
  switch (s.form) {
    case Form::kBox1:
      return meet_box<1>(s, code, rays, nearest);
    case Form::kBox2:
      return meet_box<2>(s, code, rays, nearest);
    case Form::kBox3:
      return meet_box<3>(s, code, rays, nearest);
    case Form::kSphere:
      return meet_sphere(s, code, rays, nearest);
    case Form::kTube:
      return meet_cylinder<Form::kTube>(s, code, rays, nearest);
    case Form::kCylinderSide:
      return meet_cylinder<Form::kCylinderSide>(s, code, rays, nearest);
    case Form::kCylinderCap:
      return meet_cylinder<Form::kCylinderCap>(s, code, rays, nearest);
    case Form::kCylinderBoth:
      return meet_cylinder<Form::kCylinderBoth>(s, code, rays, nearest);
    case Form::kPlane:
      return meet_plane(s, code, rays, nearest);
  }
}

}  // namespace skybody::render::kernels::SKYBODY_KERNEL_SET
