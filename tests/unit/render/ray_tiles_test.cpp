// Images of rays in any directions, drawn by the tiles of a cube's faces.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/render/scenes.h"

namespace skybody::testing {
namespace {

using ::testing::Each;

/// Hash of the images of AllKernelsGiveTheSameBits. It changes with the renderer's arithmetic only.
constexpr std::uint64_t kPinned = 4994612142947488467u;

/// Directions all over the sphere: columns in azimuth, rows in elevation, and some of the axes.
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

/// The directions of a grid's pixels.
RayImage rays_of(const Pinhole& c) {
  RayImage image{c.width, c.height, {}};
  for (int row = 0; row < c.height; ++row) {
    for (int column = 0; column < c.width; ++column) {
      image.directions.push_back(
          {(column + 0.5 - c.center_x) / c.focal_x, (row + 0.5 - c.center_y) / c.focal_y, 1.0});
    }
  }
  return image;
}

/// The nearest shape along a unit vector, and whether directions beside it see the same one at
/// about the same range.
struct Around {
  double range = HUGE_VAL;
  int shape = -1;
  bool is_smooth = true;
};
Around around(const std::vector<PlacedShape>& shapes, const Eye& eye, const Vec3<double>& along) {
  const auto nearest = [&](const Vec3<double>& d) {
    Around seen;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      const double range = range_along(shapes[i], eye, d / norm(d));
      if (range < seen.range && range < 100.0) seen = {range, static_cast<int>(i), true};
    }
    return seen;
  };
  constexpr double kEdge = 2e-4;  // far beyond the rounding of directions in float
  Around middle = nearest(along);
  for (int k = 0; k < 6; ++k) {
    Vec3<double> aside{0.0, 0.0, 0.0};
    (k / 2 == 0 ? aside.x : k / 2 == 1 ? aside.y : aside.z) = k % 2 == 0 ? kEdge : -kEdge;
    const Around beside = nearest(along + aside);
    middle.is_smooth &= beside.shape == middle.shape;
    // Steep views multiply the error of a direction.
    middle.is_smooth &=
        middle.shape < 0 || std::abs(beside.range - middle.range) < 10.0 * kEdge * middle.range;
  }
  return middle;
}

TEST(RayTilesTest, RangesInAllDirectionsAreThoseOfRaysInDouble) {
  RandomScenes scenes(11);
  const RayImage rays = all_around(72, 37);
  Camera camera(rays);
  int compared = 0;
  for (int k = 0; k < 30; ++k) {
    const std::vector<PlacedShape> shapes = scenes.scene(30);
    const Eye eye = scenes.eye(5.0);
    const bool is_inside = std::any_of(shapes.begin(), shapes.end(), [&](const PlacedShape& s) {
      return contains(s, eye.position);
    });
    if (is_inside) continue;
    camera.draw(eye, shapes);
    for (std::size_t i = 0; i < camera.pixels(); ++i) {
      const Around seen = around(shapes, eye, rays.directions[i]);
      if (!seen.is_smooth) continue;
      ++compared;
      ASSERT_EQ(camera.instance[i], seen.shape + 1) << "scene " << k << ", pixel " << i;
      const double range = std::min(seen.range, 100.0);
      ASSERT_NEAR(camera.range[i], range, 1e-5 * range) << "scene " << k << ", pixel " << i;
      if (seen.shape < 0) continue;
      const double depth = range * rays.directions[i].z;
      ASSERT_NEAR(camera.depth[i], depth, 1e-5 * range);
    }
  }
  EXPECT_GT(compared, 30000);
}

TEST(RayTilesTest, RaysOfAGridGiveThePinholesImage) {
  RandomScenes scenes(12);
  const Pinhole pinhole = square_of(40);
  Camera grid(pinhole), rays(rays_of(pinhole));
  int compared = 0;
  for (int k = 0; k < 20; ++k) {
    const std::vector<PlacedShape> shapes = scenes.scene(25);
    const Eye eye = scenes.eye(5.0);
    grid.draw(eye, shapes);
    rays.draw(eye, shapes);
    int other_colors = 0;
    for (std::size_t i = 0; i < grid.pixels(); ++i) {
      // A grid's farthest value is a depth, that of rays a range.
      if (grid.instance[i] != 0 && grid.range[i] > 99.0f) continue;
      ++compared;
      ASSERT_EQ(grid.instance[i], rays.instance[i]);
      ASSERT_EQ(grid.label[i], rays.label[i]);
      ASSERT_EQ(grid.range[i], rays.range[i]);
      // The depth comes from the range and a cosine: three roundings.
      ASSERT_NEAR(grid.depth[i], rays.depth[i], 4e-7f * grid.depth[i]);
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_EQ(grid.normal[3 * i + c], rays.normal[3 * i + c]);
      }
      other_colors += grid.rgb[3 * i] != rays.rgb[3 * i] ? 1 : 0;
    }
    // Squares of the ground fade by the size of a pixel, which rays have from their directions.
    EXPECT_LT(other_colors, static_cast<int>(grid.pixels() / 50));
  }
  EXPECT_GT(compared, 20000);
}

TEST(RayTilesTest, NormalsAreInCameraAxesOnEveryFaceOfTheCube) {
  const RayImage rays = all_around(40, 20);
  Camera camera(rays);
  const std::vector<PlacedShape> room{shape_at(Solid::kSphere, {0.0, 0.0, 0.0}, {0.5, 0.0, 0.0})};
  for (int k = 0; k < 40; ++k) {
    RandomScenes scenes(static_cast<std::uint32_t>(k) + 20);
    const Eye eye{scenes.point(1.5), looking(0.3 * k, 0.1 * k - 1.0, 0.7 * k)};
    if (contains(room[0], eye.position)) continue;
    camera.draw(eye, room);
    for (std::size_t i = 0; i < camera.pixels(); ++i) {
      if (camera.instance[i] == 0) continue;
      const Vec3<double> d = rays.directions[i] / norm(rays.directions[i]);
      const Vec3<double> point = eye.position + eye.axes * d * static_cast<double>(camera.range[i]);
      const Vec3<double> out = transpose_times(eye.axes, point) / 0.5;
      for (int c = 0; c < 3; ++c) {
        const double expected = c == 0 ? out.x : c == 1 ? out.y : out.z;
        EXPECT_NEAR(camera.normal[3 * i + static_cast<std::size_t>(c)], expected, 2e-4);
      }
    }
  }
}

TEST(RayTilesTest, SurfacesBeyondTheFarthestRangeAreNotSeen) {
  Camera camera(all_around(36, 18), 8, 5.0);
  const std::vector<PlacedShape> shapes{shape_at(Solid::kPlane, {0.0, 0.0, 0.0}, {})};
  camera.draw({{0.0, 0.0, 3.0}, looking(0.0, 0.0, 0.0)}, shapes);
  for (std::size_t i = 0; i < camera.pixels(); ++i) {
    EXPECT_EQ(camera.instance[i] == 0, camera.range[i] == 5.0f);
    EXPECT_LE(camera.range[i], 5.0f);
  }
  EXPECT_GT(std::count(camera.instance.begin(), camera.instance.end(), 1), 50);
}

TEST(RayTilesTest, AllKernelsGiveTheSameBits) {
  std::vector<std::uint64_t> hashes;
  for (const KernelTable* table : all_kernels()) {
    RandomScenes scenes(14);
    Camera camera(all_around(75, 31), 64, 30.0, *table);
    HashChain chain(1);
    for (int k = 0; k < 40; ++k) {
      const std::vector<PlacedShape> shapes = scenes.scene(k + 1);
      camera.draw(scenes.eye(k % 2 == 0 ? 5.0 : 1000.0 * k), shapes);
      camera.add_to(chain);
    }
    hashes.push_back(chain.value());
  }
  EXPECT_THAT(hashes, Each(kPinned));
}

}  // namespace
}  // namespace skybody::testing
