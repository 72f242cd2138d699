// The loops of the renderer, once for each instruction set. Plain functions and types only: files
// compiled for AVX-512 include this header, so it must not include inline functions of the standard
// library (the linker could choose their AVX-512 copy for every processor).
#pragma once

#include <stdint.h>

#include "core/base/simd/isa_sets.h"

namespace skybody::render {

/// Pixels of a tile, the unit of drawing: the same for all instruction sets, so that the order and
/// the number of tests of a pixel are, too.
inline constexpr int kTileWidth = 16;
inline constexpr int kTileHeight = 4;
inline constexpr int kTilePixels = kTileWidth * kTileHeight;

/// Forms of a convex shape as seen from an eye outside of it. A ray eye + t d is inside a shape for
/// t in an interval. The kernels compute with the inverse w = 1 / t: entry and exit are then linear
/// in d, or roots of a quadratic, without a division.
enum class Form : int32_t {
  kBox1,          ///< the eye is outside of one pair of faces
  kBox2,          ///< ... of two
  kBox3,          ///< ... of three
  kSphere,        ///< normal: radial
  kTube,          ///< the side of a cylinder, between its ends; without caps
  kCylinderSide,  ///< the eye is outside of the round, between the planes of the caps
  kCylinderCap,   ///< the eye is within the round, beyond a cap
  kCylinderBoth,  ///< the eye is outside of the round and beyond a cap
  kPlane          ///< the half-space below a plane
};

/// A linear function of a pixel's direction (x, y, 1) in camera axes (right, down, forward).
struct Linear {
  float c, x, y;
};

/// A rectangle of directions x, y (camera axes, at depth 1) that contains a shape's image.
struct Cover {
  float left, right, top, bottom;
};

/// Most levels of a texture: from 4096 pixels down to one.
inline constexpr int kMostLevels = 13;

/// Rows of texels from the top: red, green << 8, blue << 16.
struct TexelLevel {
  const uint32_t* texels;
  int32_t width, height;
};

/// A picture and its halves.
struct TexelLevels {
  TexelLevel level[kMostLevels];
  int32_t count;
};

/// How a texture lies on a shape.
enum class TextureForm : int32_t { kPlane, kBox, kSphere, kCylinder, kMesh };

/// Numbers of a triangle's texture: u to the right and v up of each corner, and their change by a
/// metre.
inline constexpr int kTexturePoints = 7;

/// A shape with a texture, in camera axes, made by lay_texture().
///
/// form       scale                                    place
/// kPlane     pictures per metre along x, y            of the eye, in pictures, modulo 1
/// others     1 / half the size along x, y, z
struct TexturedShape {
  TextureForm form;
  const TexelLevels* texels;
  float center[3];   ///< of the shape's frame, from the eye [m]
  float axis[3][3];  ///< unit vectors of the shape's frame
  float scale[3];    ///< [1/m]
  float place[2];
  const float* points;  ///< kMesh: kTexturePoints per triangle
};

/// A shape with constants of one eye and camera orientation, made by see().
///
/// form             functions                                       numbers
/// kBoxN            w of entry of each outer pair, then of exits    ratio of exit to entry
/// kPlane           w of entry
/// kSphere          B, cross product with d: z; x, y by numbers     k, cross product: c y z
/// kTube, kCylinder B, G_x, G_y, cross product, axial part          see hits.h
struct SeenShape {
  Form form;
  int32_t shape;  ///< number of the shape that it is a part of
  uint32_t id;    ///< instance, and class << 16
  Linear f[5];
  float n[6];

  // For normals and shades, in camera axes:
  float center[3];       ///< [m]
  float axis[3][3];      ///< unit vectors of the shape's frame; of boxes and caps, towards the eye
  float inverse_radius;  ///< [1/m]; 0: flat faces only
  float color[3];        ///< red, green, blue, linear, in [0, 1]
  float checker[3];      ///< colour of every other square of a plane
  float square;          ///< 1 / edge length of the squares of a plane [1/m]; 0: none
  float place[2];        ///< of the eye in the squares' axes, in edge lengths, modulo 2
  const TexturedShape* textured;  ///< null: `color` and `checker`
};

/// Most lanes of a kernel: arrays for the kernels are padded to multiples of it.
inline constexpr int kMostLanes = 16;

/// A triangle of a mesh as seen from an eye.
struct SeenTriangle {
  Linear f[4];  ///< w of its plane; three edges, at least 0 inside
  Cover cover;
  uint32_t id;       ///< as SeenShape::id
  int32_t part;      ///< index of the SeenShape that has its mesh's paint
  int32_t triangle;  ///< its index in the mesh
};

/// Pixel centres of a grid along an axis: first, first + step, ...
struct GridAxis {
  float first, inverse_step, count;
};

/// A mesh to be seen from an eye.
struct MeshCall {
  const float* coordinates[9];  ///< x, y, z of each corner, `count` each, padded
  int count;
  float eye[3];       ///< in the mesh's frame [m]
  float eye_rest[3];  ///< the rounding error of `eye`
  float axes[3][3];   ///< rows: axes of the camera, in the mesh's frame
  bool has_grid;      ///< triangles without a pixel centre are left out
  GridAxis columns, rows;
  uint32_t id;
  int32_t part;
  SeenTriangle* seen;  ///< room for `count`
};

/// Codes of surfaces: -1 nothing, 4 * index of a shape + its face, or below -1 a triangle.
constexpr int32_t code_of_triangle(int32_t index) { return -2 - index; }
constexpr int32_t triangle_of_code(int32_t code) { return -2 - code; }

/// A tile of an image.
struct TileCall {
  const SeenShape* shapes;
  const uint16_t* list;  ///< indices of the shapes that may be seen in it, ascending
  int count;             ///< of the list
  const SeenTriangle* triangles;
  const uint16_t* triangle_list;  ///< as `list`
  int triangle_count;
  bool is_scattered;  ///< rays have directions one by one, and `farthest` is their range
  const float* x;     ///< kTileWidth directions; scattered: kTilePixels
  const float* y;     ///< kTileHeight directions; scattered: kTilePixels
  float farthest;     ///< [m]
  float* depth;       ///< kTilePixels, along the optical axis [m]; `farthest` for id 0
  uint32_t* id;       ///< kTilePixels; 0: nothing
  int32_t* surface;   ///< kTilePixels: codes of surfaces; null: not wanted
};

/// Forms of bodies that cast shadows.
enum class CasterForm : int32_t { kBox, kSphere, kCylinder };

/// A convex shape between surfaces and the sun, in camera axes, made by cast(). With a point p from
/// the eye and t along the way to the sun s:
///
/// form       functions a(p) = n[i] . p + n[i][3]      numbers
/// kBox       entries and exits at -a +- e per axis    e
/// kSphere    p from the centre                        r^2
/// kCylinder  x, y, and -z / s_z in its frame          s_x, s_y, s_x^2 + s_y^2, its inverse, r^2, e
struct Caster {
  CasterForm form;
  int32_t shape;  ///< number of its shape, which does not shade itself
  float n[3][4];
  float e[6];
};

/// Bounds of casters along three axes: across the way to the sun, and towards it. Arrays of one
/// value per caster, with room for kMostLanes more.
struct CasterBounds {
  float *low[2], *high[2];
  float* top;
};

/// Light and sky, in camera axes.
struct Light {
  float sun[3];      ///< unit vector towards the sun
  float side[2][3];  ///< unit vectors across it
  float up[3];       ///< unit vector, z of W
  float direct;      ///< brightness of a white surface that faces the sun, without `ambient`
  float ambient;     ///< brightness of a white surface in shadow
  float zenith[3];   ///< colours of the sky: red, green, blue, linear, in [0, 1]
  float horizon[3];
  float haze;   ///< squared depth at which surfaces have half the colour of the horizon; 0: none
  float pixel;  ///< tangent of the widest angle between neighbouring pixels

  const Caster* casters;
  CasterBounds bounds;
  int32_t caster_count;
};

/// Normals and colours of a drawn tile with surfaces.
struct ShadeCall {
  const TileCall* tile;
  const Light* light;
  uint16_t* list;     ///< scratch: light->caster_count indices
  float* normal;      ///< x, y, z in camera axes, kTilePixels each; 0 for id 0; null: not wanted
  uint32_t* color;    ///< kTilePixels: red, green << 8, blue << 16; null: not wanted
  bool has_textures;  ///< some shapes are textured
};

/// The functions for one instruction set.
struct KernelTable {
  /// Writes the triangles that may be seen. @returns their number
  int (*see_triangles)(const MeshCall&);
  /// Depth and id of each pixel, and the surface if wanted.
  void (*draw)(const TileCall&);
  void (*shade)(const ShadeCall&);
};

#define SKYBODY_ROW(NAME, LANES, TARGET) \
  namespace kernels::NAME {              \
  extern const KernelTable kTable;       \
  }
SKYBODY_ISAS(SKYBODY_ROW)
#undef SKYBODY_ROW

}  // namespace skybody::render
