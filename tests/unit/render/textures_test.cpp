// Textures: where a picture lies on each kind of shape, means of distant ones, same bits.
#include <gtest/gtest.h>

#include "core/base/math/math.h"
#include "render/mesh.h"
#include "render/texture.h"
#include "tests/unit/render/scenes.h"

namespace skybody::testing {
namespace {

constexpr double kQuarter = 1.5707963267948966;

/// Light in which pixels show the colours of surfaces.
Sky white() {
  Sky sky;
  sky.direct = 0.0f;
  sky.ambient = 1.0f;
  sky.has_shadows = false;
  return sky;
}

/// Red grows to the right, green down; blue says that a texture is seen.
std::vector<std::uint8_t> gradient(int width, int height) {
  std::vector<std::uint8_t> rgb;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      rgb.push_back(static_cast<std::uint8_t>(255 * (2 * column + 1) / (2 * width)));
      rgb.push_back(static_cast<std::uint8_t>(255 * (2 * row + 1) / (2 * height)));
      rgb.push_back(200);
    }
  }
  return rgb;
}
const Texture& gradient_texture() {
  static const Texture texture(gradient(256, 128), 256, 128);
  return texture;
}

PlacedShape textured(PlacedShape shape, const Texture& texture = gradient_texture()) {
  shape.paint.texture = &texture;
  return shape;
}

/// Draws one shape. @returns the colours of its pixels
Camera drawn(const PlacedShape& shape, const Eye& eye, int size = 64,
             const Capacity& most = {8, 64, 8}) {
  Camera camera(square_of(size), most);
  camera.draw(eye, {shape}, white());
  return camera;
}

/// Whether a pixel shows the gradient at (u, v), to two bytes; at the picture's border, which is
/// held or mixed with the opposite one, it may not.
void expect_place(const Camera& camera, std::size_t pixel, double u, double v) {
  ASSERT_EQ(camera.rgb[3 * pixel + 2], 200);
  if (std::max(std::abs(u - 0.5), std::abs(v - 0.5)) > 0.43) return;
  EXPECT_NEAR(camera.rgb[3 * pixel], 255 * u, 2.5);
  EXPECT_NEAR(camera.rgb[3 * pixel + 1], 255 * v, 2.5);
}

TEST(Textures, AFaceOfABoxShowsThePictureUprightFromOutside) {
  const Vec3<double> half{0.5, 0.5, 0.5};
  const PlacedShape box = textured(shape_at(Solid::kBox, {1.0, 2.0, 3.0}, half));
  // An eye at each side, with the picture's top up in its image.
  const std::vector<Vec3<double>> ways{
      {0, 0, 0},         {0, 0, 2 * kQuarter},    {0, 0, kQuarter},
      {0, 0, -kQuarter}, {0, kQuarter, kQuarter}, {0, -kQuarter, kQuarter}};
  for (const Vec3<double>& way : ways) {
    const Mat3<double> axes = looking(way.x, way.y, way.z);
    const Eye eye{box.position - axes.column(2) * 1.2, axes};
    const Camera camera = drawn(box, eye);
    camera.each_pixel([&](std::size_t i, double x, double y) {
      if (std::abs(x) > 0.7 || std::abs(y) > 0.7) return;
      expect_place(camera, i, 0.5 + 0.7 * x, 0.5 + 0.7 * y);  // the face is 0.7 m away, 1 m wide
    });
  }
}

TEST(Textures, APlaneRepeatsThePictureFromTheOriginOfItsFrame) {
  PlacedShape plane = textured(shape_at(Solid::kPlane, {0.0, 0.0, 0.0}, {}));
  plane.paint.texture_width = 3.0f;
  for (const double far : {0.0, 3e4}) {  // whole numbers of pictures from the origin
    const Eye eye{{0.4 + far, 0.9, 2.0}, looking(0.0, kQuarter, kQuarter)};  // down, y is up
    const Camera camera = drawn(plane, eye);
    camera.each_pixel([&](std::size_t i, double x, double y) {
      const double u = (0.4 + 2.0 * x) / 3.0, v = -(0.9 - 2.0 * y) / 1.5;
      expect_place(camera, i, u - std::floor(u), v - std::floor(v));
    });
  }
}

TEST(Textures, APictureIsWrappedAroundSpheresAndCylinders) {
  for (const Solid solid : {Solid::kSphere, Solid::kCylinder}) {
    const PlacedShape shape = textured(shape_at(solid, {0.0, 0.0, 0.0}, {0.5, 0.5, 0.7}));
    for (const double yaw : {0.3, 1.2, 2.8, -1.9}) {
      const Mat3<double> axes = looking(0.0, 0.0, yaw);
      const Eye eye{axes.column(2) * -3.0, axes};
      Camera camera(Pinhole{64, 64, 128.0, 128.0, 32.0, 32.0}, Capacity{8, 0, 8});
      camera.draw(eye, {shape}, white());
      int seen = 0;
      camera.each_pixel([&](std::size_t i, double x, double y) {
        const Vec3<double> at =
            eye.position + axes * Vec3<double>{x, y, 1.0} * static_cast<double>(camera.depth[i]);
        // At a slant a pixel is as wide as the distance to the border.
        const bool is_whole = std::abs(at.z) < 0.3 && camera.instance[i] != 0 &&
                              std::abs(transpose_times(axes, at).x) < 0.35;
        const double u = 0.5 + std::atan2(at.y, at.x) / kTwoPi;
        if (!is_whole || std::abs(u - 0.5) > 0.48) return;
        const double rise = std::asin(at.z / norm(at)) / kPi;
        expect_place(camera, i, u, 0.5 - (solid == Solid::kSphere ? rise : at.z / 1.4));
        ++seen;
      });
      EXPECT_GT(seen, 300);
    }
  }
}

TEST(Textures, AMeshShowsThePictureByThePointsOfItsCorners) {
  // The face of a box at x = 0.5, as two triangles that show the whole picture.
  const std::vector<float> corners{0.5f, -0.5f, -0.5f, 0.5f, 0.5f, -0.5f, 0.5f, 0.5f,  0.5f,
                                   0.5f, -0.5f, -0.5f, 0.5f, 0.5f, 0.5f,  0.5f, -0.5f, 0.5f};
  const std::vector<float> points{0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1};
  const Mesh mesh(corners, {1.0, 1.0, 1.0}, points);
  PlacedShape face = textured(shape_at(Solid::kMesh, {0.0, 0.0, 0.0}, {}));
  face.mesh = &mesh;
  const PlacedShape box = textured(shape_at(Solid::kBox, {0.0, 0.0, 0.0}, {0.5, 0.5, 0.5}));
  for (const double yaw : {3.14, 2.5, -2.6}) {
    const Mat3<double> axes = looking(0.1, 0.2, yaw);
    const Eye eye{Vec3<double>{0.5, 0.0, 0.0} - axes.column(2) * 1.0, axes};
    const Camera a = drawn(face, eye), b = drawn(box, eye);
    int seen = 0, apart = 0;
    for (std::size_t i = 0; i < a.pixels(); ++i) {
      if (a.instance[i] == 0 || std::abs(a.depth[i] - b.depth[i]) > 1e-4f) continue;
      const auto differ = [&](std::size_t k) {
        const int mesh_byte = a.rgb[3 * i + k], box_byte = b.rgb[3 * i + k];
        return box_byte > 20 && box_byte < 235 && std::abs(mesh_byte - box_byte) > 4;
      };
      apart += differ(0) || differ(1) ? 1 : 0;  // not at the border, where a mesh repeats
      ++seen;
    }
    EXPECT_GT(seen, 500);
    EXPECT_LT(apart, seen / 20);
  }
}

TEST(Textures, ADistantTextureShowsItsMean) {
  std::vector<std::uint8_t> rgb;
  for (int i = 0; i < 64 * 64; ++i) {
    const bool is_white = (i + i / 64) % 2 == 0;
    rgb.insert(rgb.end(), 3, is_white ? 255 : 0);
  }
  const Texture checker(rgb, 64, 64);
  ASSERT_EQ(checker.levels().count, 7);
  PlacedShape plane = textured(shape_at(Solid::kPlane, {0.0, 0.0, 0.0}, {}), checker);
  plane.paint.texture_width = 1.0f;
  const Camera camera = drawn(plane, {{0.0, 0.0, 20.0}, looking(0.0, kQuarter, 0.0)});
  for (const std::uint8_t byte : camera.rgb) EXPECT_NEAR(byte, 128, 1);
}

TEST(Textures, APictureOfOneRowHasLevelsDownToOnePixel) {
  const std::vector<std::uint8_t> rgb{10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120};
  const Texture texture(rgb, 4, 1);
  const TexelLevels& levels = texture.levels();
  ASSERT_EQ(levels.count, 3);
  EXPECT_EQ(levels.level[1].width, 2);
  EXPECT_EQ(levels.level[1].texels[0], 25u | 35u << 8 | 45u << 16);
  EXPECT_EQ(levels.level[2].texels[0], 55u | 65u << 8 | 75u << 16);
}

/// A scene in which every other shape has a texture.
std::vector<PlacedShape> textured_scene(RandomScenes& scenes, const Mesh& mesh) {
  std::vector<PlacedShape> shapes = scenes.scene(20);
  for (std::size_t i = 0; i < shapes.size(); i += 2) shapes[i] = textured(shapes[i]);
  shapes[1] = textured(shapes[1]);
  shapes[3].solid = Solid::kMesh;
  shapes[3].mesh = &mesh;
  shapes[3] = textured(shapes[3]);
  return shapes;
}

TEST(Textures, KernelsGiveTheSameBits) {
  const std::vector<float> corners{1, -1, -1, 1, 2, -1, 0, 2, 1}, points{0, 0, 3, 0.5f, 1, 2};
  const Mesh mesh(corners, {1.0, 1.0, 1.0}, points);
  std::vector<std::uint64_t> hashes;
  for (const KernelTable* kernels : all_kernels()) {
    RandomScenes scenes(11);
    HashChain chain;
    for (int k = 0; k < 20; ++k) {
      Camera camera(square_of(48), Capacity{32, 8, 32}, 100.0, *kernels);
      const std::vector<PlacedShape> shapes = textured_scene(scenes, mesh);
      camera.draw(scenes.eye(5.0), shapes);
      camera.add_to(chain);
    }
    hashes.push_back(chain.value());
  }
  for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, hashes[0]);
}

TEST(Textures, ScatteredRaysSeeWhatAGridSees) {
  const std::vector<float> corners{1, -1, -1, 1, 2, -1, 0, 2, 1}, points{0, 0, 3, 0.5f, 1, 2};
  const Mesh mesh(corners, {1.0, 1.0, 1.0}, points);
  const Capacity most{32, 8, 32};
  RayImage rays{48, 48, {}};
  Camera grid(square_of(48), most);
  grid.each_pixel([&](std::size_t, double x, double y) { rays.directions.push_back({x, y, 1.0}); });
  Camera scattered(rays, most, 200.0);
  RandomScenes scenes(5);
  std::size_t apart = 0, pixels = 0;
  for (int k = 0; k < 10; ++k) {
    const std::vector<PlacedShape> shapes = textured_scene(scenes, mesh);
    const Eye eye = scenes.eye(5.0);
    grid.draw(eye, shapes);
    scattered.draw(eye, shapes);
    for (std::size_t i = 0; i < grid.rgb.size(); ++i) {
      // The footprint of a pixel is another one: its widest angle, not the focal length.
      apart += std::abs(grid.rgb[i] - scattered.rgb[i]) > 12 ? 1 : 0;
    }
    pixels += grid.rgb.size();
  }
  EXPECT_LT(apart, pixels / 50);
}

TEST(Textures, LeaveDepthsAndNormalsAlone) {
  const Mesh mesh(std::vector<float>{1, -1, -1, 1, 2, -1, 0, 2, 1}, {1.0, 1.0, 1.0},
                  std::vector<float>{0, 0, 3, 0.5f, 1, 2});
  RandomScenes scenes(7);
  std::vector<PlacedShape> shapes = textured_scene(scenes, mesh);
  const Eye eye = scenes.eye(5.0);
  Camera with(square_of(48), Capacity{32, 8, 32}), without(square_of(48), Capacity{32, 8});
  with.draw(eye, shapes);
  for (PlacedShape& shape : shapes) shape.paint.texture = nullptr;
  without.draw(eye, shapes);
  EXPECT_EQ(with.depth, without.depth);
  EXPECT_EQ(with.instance, without.instance);
  EXPECT_EQ(with.normal, without.normal);
  EXPECT_NE(with.rgb, without.rgb);
}

}  // namespace
}  // namespace skybody::testing
