// Random scenes, and their rays in double by other equations than the renderer's: intervals of
// slabs and rounds (plugins/obstacles/ray.h).
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "core/base/math/hash.h"
#include "core/base/math/quat.h"
#include "plugins/obstacles/ray.h"
#include "render/renderer.h"
#include "render/seen_shape.h"

namespace skybody::render::kernels::scalar {
extern const KernelTable kTable;  // compiled for these tests
}

namespace skybody::testing {

using namespace render;

/// The kernels of one lane, and those of every instruction set that the machine has.
inline std::vector<const KernelTable*> all_kernels() {
  std::vector<const KernelTable*> tables{&render::kernels::scalar::kTable};
  for (const Isa isa : kIsas) {
    if (machine_has(isa)) tables.push_back(&kernels_of(isa));
  }
  return tables;
}

inline Mat3<double> turned(double roll, double pitch, double yaw) {
  return to_mat3(from_rpy(roll, pitch, yaw));
}

/// W from camera axes, if the camera looks along x of a body at that attitude.
inline Mat3<double> looking(double roll, double pitch, double yaw) {
  Mat3<double> mount{};  // body (forward, left, up) from camera (right, down, forward)
  mount(0, 2) = 1.0;
  mount(1, 0) = -1.0;
  mount(2, 1) = -1.0;
  return turned(roll, pitch, yaw) * mount;
}

inline PlacedShape shape_at(Solid solid, const Vec3<double>& position, const Vec3<double>& half,
                            const Mat3<double>& axes = turned(0, 0, 0)) {
  PlacedShape shape;
  shape.solid = solid;
  shape.position = position;
  shape.axes = axes;
  shape.half = half;
  shape.instance = 1;
  shape.label = Label::kObstacle;
  return shape;
}

/// Distance to a shape along a unit vector of camera axes; infinite if there is none.
inline double range_along(const PlacedShape& shape, const Eye& eye, const Vec3<double>& direction) {
  const Vec3<double> along = eye.axes * direction;
  const obstacles::Ray<double> ray{transpose_times(shape.axes, eye.position - shape.position),
                                   transpose_times(shape.axes, along)};
  const double radius = shape.half.x, half = shape.half.z;
  switch (shape.solid) {
    case Solid::kBox:
      return obstacles::in_box(ray, shape.half).first();
    case Solid::kSphere:
      return obstacles::in_sphere(ray, radius).first();
    case Solid::kCylinder:
      return obstacles::in_cylinder(ray, radius, half).first();
    case Solid::kCapsule: {
      double nearest = obstacles::in_cylinder(ray, radius, half).first();
      for (const double end : {half, -half}) {
        const obstacles::Ray<double> to_end{ray.from - Vec3<double>{0.0, 0.0, end}, ray.along};
        nearest = std::min(nearest, obstacles::in_sphere(to_end, radius).first());
      }
      return nearest;
    }
    case Solid::kPlane:
      return obstacles::until_plane(ray);
    case Solid::kMesh:
      break;  // see mesh_test.cpp
  }
  return HUGE_VAL;
}

/// Distance along the optical axis to a shape in the direction (x, y, 1) of camera axes; infinite
/// if there is none.
inline double depth_along(const PlacedShape& shape, const Eye& eye, double x, double y) {
  const double length = std::sqrt(x * x + y * y + 1.0);
  return range_along(shape, eye, {x / length, y / length, 1.0 / length}) / length;
}

/// The nearest of some shapes in a direction.
struct Sight {
  double depth = HUGE_VAL;
  int shape = -1;
};
inline Sight sight_along(const std::vector<PlacedShape>& shapes, const Eye& eye, double x, double y,
                         double farthest) {
  Sight sight;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const double depth = depth_along(shapes[i], eye, x, y);
    if (depth < sight.depth && depth < farthest) sight = {depth, static_cast<int>(i)};
  }
  return sight;
}

/// Draws of shapes, eyes and scenes.
class RandomScenes {
 public:
  explicit RandomScenes(std::uint32_t seed) : generator_(seed) {}

  double between(double low, double high) {
    return low + (high - low) * (static_cast<double>(generator_() >> 5) / (1u << 27));
  }
  Vec3<double> point(double reach) {
    return {between(-reach, reach), between(-reach, reach), between(-reach, reach)};
  }
  /// Roll, pitch, yaw. Drawn in a list: the order of a function's arguments is the compiler's.
  Vec3<double> angles() { return {between(-3.1, 3.1), between(-1.5, 1.5), between(-3.1, 3.1)}; }
  PlacedShape shape(Solid solid, double reach) {
    const Vec3<double> half{between(0.1, 1.0), between(0.1, 1.0), between(0.1, 1.5)};
    const Vec3<double> position = point(reach), turn = angles();
    return shape_at(solid, position, half, turned(turn.x, turn.y, turn.z));
  }
  Eye eye(double reach) {
    const Vec3<double> position = point(reach), turn = angles();
    return {position, looking(turn.x, turn.y, turn.z)};
  }
  /// Shapes of all kinds, numbered from 1.
  std::vector<PlacedShape> scene(int count) {
    std::vector<PlacedShape> shapes{shape_at(Solid::kPlane, {0.0, 0.0, -6.0}, {})};
    for (int i = 1; i < count; ++i) {
      const Solid solids[] = {Solid::kBox, Solid::kSphere, Solid::kCylinder, Solid::kCapsule};
      shapes.push_back(shape(solids[i % 4], 6.0));
      shapes.back().instance = static_cast<std::uint16_t>(i + 1);
      shapes.back().paint.color = {0.1f * static_cast<float>(i % 7), 0.5f, 0.9f};
    }
    shapes[0].paint = {{0.2f, 0.3f, 0.4f}, {0.6f, 0.7f, 0.8f}, 1.0f};
    return shapes;
  }

 private:
  std::mt19937 generator_;
};

/// A renderer with its memory and all of its images.
struct Camera {
  Pinhole pinhole;  ///< of a grid
  Renderer renderer;
  int most_shapes;
  std::vector<double> scratch;
  std::vector<float> depth, range, normal;
  std::vector<std::uint16_t> instance;
  std::vector<std::uint8_t> label, rgb;

  explicit Camera(const Pinhole& grid, const Capacity& most = 64, double farthest = 100.0,
                  const KernelTable& kernels = kernels_of(best_isa()))
      : Camera(grid, Renderer(grid, most, farthest, kernels), most) {}
  explicit Camera(const RayImage& rays, const Capacity& most = 64, double farthest = 100.0,
                  const KernelTable& kernels = kernels_of(best_isa()))
      : Camera(Pinhole{}, Renderer(rays, most, farthest, kernels), most) {}
  Camera(const Pinhole& grid, const Renderer& drawn_by, const Capacity& most)
      : pinhole(grid),
        renderer(drawn_by),
        most_shapes(most.shapes),
        scratch(renderer.scratch_size()),
        depth(pixels()),
        range(pixels()),
        normal(3 * pixels()),
        instance(pixels()),
        label(pixels()),
        rgb(3 * pixels()) {}

  std::size_t pixels() const {
    return static_cast<std::size_t>(renderer.width()) * static_cast<std::size_t>(renderer.height());
  }
  void draw(const Eye& eye, const std::vector<PlacedShape>& shapes, const Sky& sky = {}) {
    renderer.draw(
        eye, shapes, sky, scratch.data(),
        {depth.data(), range.data(), instance.data(), label.data(), normal.data(), rgb.data()});
  }
  /// Adds all images to a hash.
  void add_to(HashChain& chain) const {
    for (std::size_t i = 0; i < pixels(); ++i) {
      chain.update(static_cast<double>(depth[i]));
      chain.update(static_cast<double>(range[i]));
      chain.update(std::uint64_t{instance[i]} << 8 | label[i]);
      for (std::size_t c = 0; c < 3; ++c) {
        chain.update(static_cast<double>(normal[3 * i + c]));
        chain.update(std::uint64_t{rgb[3 * i + c]});
      }
    }
  }
  /// Calls function(index, x, y) for each pixel with its direction.
  template <class Function>
  void each_pixel(Function&& function) const {
    const Pinhole& c = pinhole;
    for (int row = 0; row < c.height; ++row) {
      for (int column = 0; column < c.width; ++column) {
        function(static_cast<std::size_t>(row * c.width + column),
                 (column + 0.5 - c.center_x) / c.focal_x, (row + 0.5 - c.center_y) / c.focal_y);
      }
    }
  }
};

/// A square image with a field of view of 90 degrees.
inline Pinhole square_of(int size) {
  return {size, size, 0.5 * size, 0.5 * size, 0.5 * size, 0.5 * size};
}

}  // namespace skybody::testing
