// The fixed scene that bench_render and bench_peer_embree draw: 42 shapes and the ground, ten
// trees, balls and boxes, three gates of four bars, four robots of five boxes.
#pragma once

#include <time.h>

#include <cstdint>
#include <vector>

#include "core/base/math/quat.h"
#include "render/mesh.h"
#include "render/scene.h"

namespace skybody::bench {

inline double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

inline Mat3<double> turned(double yaw) { return to_mat3(from_rpy(0.0, 0.0, yaw)); }

/// The scene, with places from a linear congruential generator.
class Scene {
 public:
  Scene() {
    add(render::Solid::kPlane, {0.0, 0.0, 0.0}, 0.0, {});
    shapes.back().paint = {{0.4f, 0.4f, 0.4f}, {0.6f, 0.6f, 0.6f}, 1.0f};
    for (int i = 0; i < 10; ++i) add_thing(i);
    for (int i = 0; i < 3; ++i) add_gate(3.0 + 3.0 * i);
    for (int i = 0; i < 4; ++i) add_robot();
  }
  /// Trees within 20 m of the origin, of which those nearest have 2 m to it.
  static Scene forest(int trees) {
    Scene scene;
    scene.shapes.resize(1);
    for (int i = 0; i < trees; ++i) {
      const double distance = scene.between(2.0, 20.0), angle = scene.between(0.0, kTwoPi);
      const SinCos<double> turn = sincos(angle);
      const double radius = scene.between(0.1, 0.3);
      scene.add(render::Solid::kCapsule, {distance * turn.cos, distance * turn.sin, 3.0}, 0.0,
                {radius, radius, 3.0});
    }
    return scene;
  }
  /// Robots of one mesh, 1.5 to 3 m ahead.
  static Scene robots(const render::Mesh& mesh, int count) {
    Scene scene;
    scene.shapes.resize(1);
    for (int i = 0; i < count; ++i) {
      scene.add(render::Solid::kMesh, {1.5 + 0.5 * i, 0.5 * i - 0.7, scene.between(1.1, 1.7)},
                scene.between(0.0, 6.0), {});
      scene.shapes.back().mesh = &mesh;
    }
    return scene;
  }
  std::vector<render::PlacedShape> shapes;

 private:
  double next() {
    state_ = state_ * 1664525u + 1013904223u;
    return (state_ >> 8) / 16777216.0;
  }
  double between(double low, double high) { return low + (high - low) * next(); }

  void add(render::Solid solid, const Vec3<double>& position, double yaw,
           const Vec3<double>& half) {
    render::PlacedShape shape;
    shape.solid = solid;
    shape.position = position;
    shape.axes = turned(yaw);
    shape.half = half;
    shape.instance = static_cast<std::uint16_t>(shapes.size() + 1);
    shape.label = render::Label::kObstacle;
    shapes.push_back(shape);
  }
  void add_thing(int i) {
    const double x = between(2.0, 10.0), y = between(-5.0, 5.0), yaw = between(0.0, 6.0);
    if (i % 2 != 0) return add(render::Solid::kCapsule, {x, y, 1.5}, 0.0, {0.15, 0.15, 1.35});
    if (i % 4 != 0) return add(render::Solid::kSphere, {x, y, 1.0}, 0.0, {0.5, 0.0, 0.0});
    add(render::Solid::kBox, {x, y, 0.5}, yaw, {0.5, 0.4, 0.5});
  }
  void add_gate(double x) {
    const double yaw = between(0.0, 6.0), y = between(-2.0, 2.0);
    const Mat3<double> axes = turned(yaw);
    for (const double side : {-0.7, 0.7}) {
      const Vec3<double> middle{x, y, 1.5};
      add(render::Solid::kBox, middle + axes.column(1) * side, yaw, {0.05, 0.05, 0.75});
      add(render::Solid::kBox, middle + axes.column(2) * side, yaw, {0.05, 0.75, 0.05});
    }
  }
  void add_robot() {
    const Vec3<double> at{between(2.5, 4.5), between(-1.0, 1.0), between(1.0, 2.0)};
    add(render::Solid::kBox, at, next(), {0.1, 0.1, 0.04});
    for (const double x : {-0.12, 0.12}) {
      for (const double y : {-0.12, 0.12}) {
        add(render::Solid::kBox, at + Vec3<double>{x, y, 0.05}, 0.0, {0.06, 0.06, 0.005});
      }
    }
  }

  std::uint32_t state_ = 1;
};

/// The eye of frame i: it looks about and moves forward.
inline render::Eye eye_at(int i) {
  Mat3<double> mount{};  // (forward, left, up) from (right, down, forward)
  mount(0, 2) = 1.0;
  mount(1, 0) = mount(2, 1) = -1.0;
  const double yaw = 0.3 * sincos(0.001 * i).sin;
  return {{-1.0 + 0.0001 * i, 0.2, 1.4}, turned(yaw) * mount};
}

/// A field of view of 90 degrees.
inline render::Pinhole pinhole_of(int size) {
  const double half = 0.5 * size;
  return {size, size, half, half, half, half};
}

}  // namespace skybody::bench
