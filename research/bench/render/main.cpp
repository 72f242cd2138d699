// Frames per second of the renderer on one core, on a fixed scene of 42 shapes and the ground: ten
// trees, balls and boxes, three gates of four bars, four robots of five boxes.
//
//   bench_render [--size N] [--frames N] [--rounds N] [--images depth|normal|rgb|lidar|mesh]
//
// lidar: 16 rings of 360 rays in a forest of 30 trees. mesh: depth of four robots of a mesh of
// 2,000 triangles each, all in view, above the ground.
//
// Prints one line of JSON: processor time, which other load affects little, and a hash of depths
// and instances.
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "core/base/math/hash.h"
#include "core/base/math/quat.h"
#include "render/mesh.h"
#include "render/renderer.h"

namespace skybody {
namespace {

using render::PlacedShape;
using render::Solid;

struct Options {
  int size = 64;
  int frames = 2000;
  int rounds = 5;
  std::string images = "depth";
};

double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Mat3<double> turned(double yaw) { return to_mat3(from_rpy(0.0, 0.0, yaw)); }

/// The scene, with places from a linear congruential generator.
class Scene {
 public:
  Scene() {
    add(Solid::kPlane, {0.0, 0.0, 0.0}, 0.0, {});
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
      scene.add(Solid::kCapsule, {distance * turn.cos, distance * turn.sin, 3.0}, 0.0,
                {radius, radius, 3.0});
    }
    return scene;
  }
  /// Robots of one mesh, 1.5 to 3 m ahead.
  static Scene robots(const render::Mesh& mesh, int count) {
    Scene scene;
    scene.shapes.resize(1);
    for (int i = 0; i < count; ++i) {
      scene.add(Solid::kMesh, {1.5 + 0.5 * i, 0.5 * i - 0.7, scene.between(1.1, 1.7)},
                scene.between(0.0, 6.0), {});
      scene.shapes.back().mesh = &mesh;
    }
    return scene;
  }
  std::vector<PlacedShape> shapes;

 private:
  double next() {
    state_ = state_ * 1664525u + 1013904223u;
    return (state_ >> 8) / 16777216.0;
  }
  double between(double low, double high) { return low + (high - low) * next(); }

  void add(Solid solid, const Vec3<double>& position, double yaw, const Vec3<double>& half) {
    PlacedShape shape;
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
    if (i % 2 != 0) return add(Solid::kCapsule, {x, y, 1.5}, 0.0, {0.15, 0.15, 1.35});
    if (i % 4 != 0) return add(Solid::kSphere, {x, y, 1.0}, 0.0, {0.5, 0.0, 0.0});
    add(Solid::kBox, {x, y, 0.5}, yaw, {0.5, 0.4, 0.5});
  }
  void add_gate(double x) {
    const double yaw = between(0.0, 6.0), y = between(-2.0, 2.0);
    const Mat3<double> axes = turned(yaw);
    for (const double side : {-0.7, 0.7}) {
      const Vec3<double> middle{x, y, 1.5};
      add(Solid::kBox, middle + axes.column(1) * side, yaw, {0.05, 0.05, 0.75});
      add(Solid::kBox, middle + axes.column(2) * side, yaw, {0.05, 0.75, 0.05});
    }
  }
  void add_robot() {
    const Vec3<double> at{between(2.5, 4.5), between(-1.0, 1.0), between(1.0, 2.0)};
    add(Solid::kBox, at, next(), {0.1, 0.1, 0.04});
    for (const double x : {-0.12, 0.12}) {
      for (const double y : {-0.12, 0.12}) {
        add(Solid::kBox, at + Vec3<double>{x, y, 0.05}, 0.0, {0.06, 0.06, 0.005});
      }
    }
  }

  std::uint32_t state_ = 1;
};

/// The eye of frame i: it looks about and moves forward.
render::Eye eye_at(int i) {
  Mat3<double> mount{};  // (forward, left, up) from (right, down, forward)
  mount(0, 2) = 1.0;
  mount(1, 0) = mount(2, 1) = -1.0;
  const double yaw = 0.3 * sincos(0.001 * i).sin;
  return {{-1.0 + 0.0001 * i, 0.2, 1.4}, turned(yaw) * mount};
}

Options read_options(int count, char** words) {
  Options options;
  for (int i = 1; i + 1 < count; i += 2) {
    const std::string name = words[i];
    if (name == "--size") options.size = std::stoi(words[i + 1]);
    if (name == "--frames") options.frames = std::stoi(words[i + 1]);
    if (name == "--rounds") options.rounds = std::stoi(words[i + 1]);
    if (name == "--images") options.images = words[i + 1];
  }
  return options;
}

/// 16 rings from -15 to 15 degrees of 360 rays, in camera axes.
render::RayImage scan() {
  render::RayImage image{360, 16, {}};
  for (int ring = 0; ring < image.height; ++ring) {
    const SinCos<double> rise = sincos((2.0 * ring - 15.0) * kPi / 180.0);
    for (int i = 0; i < image.width; ++i) {
      const SinCos<double> turn = sincos(kTwoPi * i / image.width);
      image.directions.push_back({-rise.cos * turn.sin, -rise.sin, rise.cos * turn.cos});
    }
  }
  return image;
}

/// A vehicle of 0.5 x 0.5 x 0.2 m: an ellipsoid of 2,000 triangles.
std::vector<float> vehicle_corners() {
  constexpr int kRings = 26, kColumns = 40;
  const auto point = [](int ring, int column, int axis) {
    const SinCos<double> fall = sincos(kPi * ring / kRings);
    const SinCos<double> turn = sincos(kTwoPi * column / kColumns);
    const double at[3] = {0.25 * fall.sin * turn.cos, 0.25 * fall.sin * turn.sin, 0.1 * fall.cos};
    return static_cast<float>(at[axis]);
  };
  std::vector<float> corners;
  const auto add = [&](int ring, int column) {
    for (int axis = 0; axis < 3; ++axis) corners.push_back(point(ring, column, axis));
  };
  for (int r = 0; r < kRings; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const int triangles[2][3][2] = {{{r, c}, {r + 1, c}, {r, c + 1}},
                                      {{r, c + 1}, {r + 1, c}, {r + 1, c + 1}}};
      for (int k = r > 0 ? 0 : 1; k < (r + 1 < kRings ? 2 : 1); ++k) {
        for (const auto& [ring, column] : triangles[k]) add(ring, column);
      }
    }
  }
  return corners;
}

render::Renderer renderer_of(const Options& options, const render::Capacity& most) {
  const render::KernelTable& kernels = render::kernels_of(best_isa());
  if (options.images == "lidar") return {scan(), most, 1000.0, kernels};
  const double half = 0.5 * options.size;
  const render::Pinhole pinhole{options.size, options.size, half, half, half, half};
  return {pinhole, most, 1000.0, kernels};
}

int run(const Options& options) {
  const render::Mesh mesh(vehicle_corners(), {1.0, 1.0, 1.0});
  const Scene scene = options.images == "lidar"  ? Scene::forest(30)
                      : options.images == "mesh" ? Scene::robots(mesh, 4)
                                                 : Scene();
  const render::Renderer renderer =
      renderer_of(options, {static_cast<int>(scene.shapes.size()), 4 * mesh.count()});
  const auto pixels =
      static_cast<std::size_t>(renderer.width()) * static_cast<std::size_t>(renderer.height());
  std::vector<double> scratch(renderer.scratch_size());
  std::vector<float> depth(pixels), normal(3 * pixels);
  std::vector<std::uint16_t> instance(pixels);
  std::vector<std::uint8_t> rgb(3 * pixels);
  render::Frame frame;
  (options.images == "lidar" ? frame.range : frame.depth) = depth.data();
  frame.instance = instance.data();
  if (options.images == "normal") frame.normal = normal.data();
  if (options.images == "rgb") frame.rgb = rgb.data();
  double least = 1e9;
  HashChain chain(1);
  for (int round = 0; round < options.rounds; ++round) {
    const double start = processor_time();
    for (int i = 0; i < options.frames; ++i) {
      renderer.draw(eye_at(i), scene.shapes, {}, scratch.data(), frame);
      if (round > 0 || i % 97 != 0) continue;
      for (std::size_t k = 0; k < pixels; ++k) {
        chain.update(static_cast<double>(depth[k]));
        chain.update(instance[k]);
      }
    }
    if (round > 0 || options.rounds == 1) least = std::min(least, processor_time() - start);
  }
  const double rate = options.frames / least;
  std::printf(
      "{\"shapes\": %zu, \"size\": %d, \"images\": \"%s\", \"frames_per_second\": %.0f, "
      "\"rays_per_second\": %.4g, \"hash\": \"%016llx\"}\n",
      scene.shapes.size() - 1, options.size, options.images.c_str(), rate,
      rate * static_cast<double>(pixels), static_cast<unsigned long long>(chain.value()));
  return 0;
}

}  // namespace
}  // namespace skybody

int main(int count, char** words) { return skybody::run(skybody::read_options(count, words)); }
