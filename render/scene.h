// Shapes to draw, and the camera that sees them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/math/mat3.h"
#include "core/base/math/vec3.h"

namespace skybody::render {

/// Kinds of solids.
enum class Solid {
  kBox,
  kSphere,
  kCylinder,  ///< about z
  kCapsule,   ///< about z
  kPlane,     ///< the half-space below z = 0
  kMesh       ///< the triangles of a Mesh
};

/// The class of a shape. The numbers are pixels of class images.
enum class Label : std::uint8_t { kNothing = 0, kGround = 1, kRobot = 2, kObstacle = 3, kGate = 4 };

/// Red, green and blue, linear, each in [0, 1].
using Color = std::array<float, 3>;

class Texture;

/// The surface of a shape.
struct Paint {
  Color color{0.5f, 0.5f, 0.5f};
  Color checker{0.5f, 0.5f, 0.5f};   ///< every other square of a plane
  float square = 0.0f;               ///< edge length of the squares of a plane [m]; 0: none
  const Texture* texture = nullptr;  ///< in place of the colours; of a mesh with texture points
  float texture_width = 1.0f;        ///< of the picture on a plane, which repeats it [m]
};

class Mesh;

/// A shape at its place in the world.
struct PlacedShape {
  Solid solid = Solid::kSphere;
  std::int32_t body = -1;                ///< for the caller: the body that it moves with; -1: none
  Vec3<double> position{0.0, 0.0, 0.0};  ///< of its frame, W [m]
  Mat3<double> axes;                     ///< W from its frame
  Vec3<double> half{0.0, 0.0, 0.0};      ///< half its edges; sphere: the radius in x; cylinder and
                                         ///< capsule: radius in x, half the length (of a capsule
                                         ///< between the centres of its caps) in z [m]
  std::uint16_t instance = 0;            ///< above 0
  Label label = Label::kNothing;
  Paint paint;
  const Mesh* mesh = nullptr;  ///< of a kMesh, which has no `half`
  bool casts_shadow = true;
};

/// A place to see from.
struct Eye {
  Vec3<double> position{0.0, 0.0, 0.0};  ///< W [m]
  Mat3<double> axes;  ///< W from camera axes: right, down, forward (the optical axis)
};

/// A camera without distortion. The centre of pixel (column, row) has the direction
/// ((column + 1/2 - center_x) / focal_x, (row + 1/2 - center_y) / focal_y, 1) in camera axes.
struct Pinhole {
  int width = 64, height = 64;              ///< [pixels]
  double focal_x = 32.0, focal_y = 32.0;    ///< focal lengths [pixels]
  double center_x = 32.0, center_y = 32.0;  ///< principal point [pixels]
};

/// An image whose pixels look in any directions: fisheyes, panoramas, lidars.
struct RayImage {
  int width = 0, height = 0;             ///< [pixels]
  std::vector<Vec3<double>> directions;  ///< camera axes, of any length above 0, row by row
};

/// Sun and sky.
struct Sky {
  Vec3<double> sun{0.36, 0.48, 0.8};  ///< towards the sun, W, unit
  float direct = 0.75f;               ///< brightness of a white surface that faces the sun
  float ambient = 0.3f;               ///< brightness of a white surface in shadow
  bool has_shadows = true;            ///< shapes shade each other and the ground
  Color zenith{0.25f, 0.45f, 0.8f};
  Color horizon{0.75f, 0.85f, 0.95f};
  /// Depth d at which surfaces have half the colour of the horizon [m]; its share is
  /// d^2 / (d^2 + haze^2). 0: none.
  float haze = 0.0f;
};

}  // namespace skybody::render
