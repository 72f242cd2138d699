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
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "core/base/math/hash.h"
#include "render/mesh.h"
#include "render/renderer.h"
#include "research/bench/render/scene.h"

namespace skybody {
namespace {

using bench::processor_time;
using bench::Scene;

struct Options {
  int size = 64;
  int frames = 2000;
  int rounds = 5;
  std::string images = "depth";
};

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
  return {bench::pinhole_of(options.size), most, 1000.0, kernels};
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
      renderer.draw(bench::eye_at(i), scene.shapes, {}, scratch.data(), frame);
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
