#include "tests/portable/drawn_scenes.h"

#include "core/base/math/math.h"
#include "render/mesh.h"
#include "tests/unit/render/scenes.h"

namespace skybody::test {
namespace {

using render::Mesh;
using render::PlacedShape;
using render::RayImage;
using render::Solid;
using testing::Camera;
using testing::RandomScenes;

constexpr int kScenes = 12;
constexpr int kTriangles = 60;
constexpr double kFarthest = 30.0;

/// Triangles about the origin, of any size and side.
Mesh random_mesh(RandomScenes& scenes) {
  std::vector<float> corners;
  for (int k = 0; k < kTriangles; ++k) {
    const Vec3<double> center = scenes.point(1.0);
    for (int corner = 0; corner < 3; ++corner) {
      const Vec3<double> at = center + scenes.point(0.6);
      for (const double x : {at.x, at.y, at.z}) corners.push_back(static_cast<float>(x));
    }
  }
  return Mesh(corners, {1.0, 1.2, 0.9});
}

/// Directions all over the sphere.
RayImage all_around(int width, int height) {
  RayImage image{width, height, {}};
  for (int row = 0; row < height; ++row) {
    const SinCos<double> rise = sincos(kPi * ((row + 0.5) / height - 0.5));
    for (int column = 0; column < width; ++column) {
      const SinCos<double> turn = sincos(kTwoPi * column / width);
      image.directions.push_back({rise.cos * turn.sin, rise.sin, rise.cos * turn.cos});
    }
  }
  return image;
}

}  // namespace

std::vector<DrawnScene> draw_scenes() {
  RandomScenes scenes(38);
  const Mesh mesh = random_mesh(scenes);
  const render::Capacity most(64, 2 * mesh.count());
  Camera pinhole({75, 50, 40.0, 41.0, 37.0, 24.0}, most, kFarthest);
  Camera around(all_around(60, 30), most, kFarthest);
  std::vector<DrawnScene> drawn;
  for (int k = 0; k < kScenes; ++k) {
    std::vector<PlacedShape> shapes = scenes.scene(4 * k + 2);
    for (int copy = 0; copy < 2; ++copy) {
      PlacedShape shape = scenes.shape(Solid::kMesh, 6.0);
      shape.mesh = &mesh;
      shape.instance = static_cast<std::uint16_t>(100 + copy);
      shapes.push_back(shape);
    }
    HashChain chain;
    for (Camera* camera : {&pinhole, &around}) {
      camera->draw(scenes.eye(5.0), shapes);
      camera->add_to(chain);
    }
    drawn.push_back({"scene_" + std::to_string(k), to_hex(chain.value())});
  }
  return drawn;
}

}  // namespace skybody::test
