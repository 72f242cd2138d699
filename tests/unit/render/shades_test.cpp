// Colours: light, squares of the ground, sky.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/render/scenes.h"

namespace skybody::testing {
namespace {

/// A byte of a colour, rounded.
int byte_of(double share) { return static_cast<int>(std::lround(share * 255.0)); }

/// Looks straight down from 2 m at a wide plane.
class ShadesTest : public ::testing::Test {
 protected:
  void look_down() { camera.draw({{0.3, 0.3, 2.0}, looking(0.0, 0.5 * kPi, 0.0)}, shapes, sky); }
  int red_at(std::size_t row, std::size_t column) const {
    return camera.rgb[3 * (row * 33 + column)];
  }

  Camera camera{{33, 33, 16.5, 16.5, 16.5, 16.5}};
  std::vector<PlacedShape> shapes{shape_at(Solid::kPlane, {0.0, 0.0, 0.0}, {})};
  Sky sky;
};

TEST_F(ShadesTest, BrightnessFollowsTheSunsHeight) {
  shapes[0].paint.color = {0.4f, 0.5f, 0.6f};
  sky.direct = 0.8f;
  sky.ambient = 0.1f;
  sky.sun = {0.6, 0.0, 0.8};
  look_down();
  EXPECT_NEAR(red_at(16, 16), byte_of(0.4 * (0.8 * 0.8 + 0.1)), 1);
  sky.sun = {0.6, 0.0, -0.8};  // below the horizon
  look_down();
  EXPECT_NEAR(red_at(16, 16), byte_of(0.4 * 0.1), 1);
}

TEST_F(ShadesTest, SquaresOfTheGroundAlternate) {
  shapes[0].paint = {{0.1f, 0.1f, 0.1f}, {0.9f, 0.9f, 0.9f}, 1.0f};
  sky.direct = 0.0f;
  sky.ambient = 1.0f;
  look_down();
  camera.each_pixel([&](std::size_t i, double x, double y) {
    // Right of the image is -y of W; down is -x.
    const double along = 0.3 - 2.0 * y, aside = 0.3 - 2.0 * x;
    const auto distance = [](double v) { return std::abs(v - std::round(v)); };
    if (distance(along) < 1e-3 || distance(aside) < 1e-3) return;
    const int sum = static_cast<int>(std::floor(along) + std::floor(aside));
    EXPECT_NEAR(camera.rgb[3 * i], byte_of(sum % 2 == 0 ? 0.1 : 0.9), 1) << along << ", " << aside;
  });
}

TEST_F(ShadesTest, ShadowsAreThoseOfRaysToTheSun) {
  RandomScenes scenes(6);
  Camera wide(square_of(40));
  sky.direct = 1.0f;
  sky.ambient = 0.0f;
  constexpr double kEdge = 1e-3;  // directions that all see the same light
  int in_sun = 0, in_shadow = 0;
  for (int k = 0; k < 60; ++k) {
    shapes = scenes.scene(25);
    for (PlacedShape& shape : shapes) shape.paint = {{1.0f, 1.0f, 1.0f}, {}, 0.0f};
    const Eye eye = scenes.eye(5.0);
    const Vec3<double> toward{scenes.between(-1, 1), scenes.between(-1, 1), 0.7};
    sky.sun = toward / norm(toward);
    wide.draw(eye, shapes, sky);
    if (wide.depth[0] == 0.0f) continue;
    // Number of the shape that shades a direction's surface; -1: none.
    const auto shade_at = [&](double x, double y, int& shape) {
      const Sight sight = sight_along(shapes, eye, x, y, 100.0);
      shape = sight.shape;
      if (shape < 0) return -1;
      Eye at{eye.position + eye.axes * Vec3<double>{x, y, 1.0} * sight.depth, {}};
      at.axes = Mat3<double>{};
      for (int i = 0; i < 3; ++i) {
        at.axes(i, 2) = i == 0 ? sky.sun.x : i == 1 ? sky.sun.y : sky.sun.z;
      }
      std::vector<PlacedShape> others = shapes;
      others.erase(others.begin() + shape);
      return sight_along(others, at, 0.0, 0.0, 1e9).shape;
    };
    wide.each_pixel([&](std::size_t i, double x, double y) {
      int shape = -1;
      const int shade = shade_at(x, y, shape);
      if (shape < 0) return;
      for (const double d : {-kEdge, kEdge}) {
        int other_x = -1, other_y = -1;
        if (shade_at(x + d, y, other_x) != shade || other_x != shape) return;
        if (shade_at(x, y + d, other_y) != shade || other_y != shape) return;
      }
      const float* n = &wide.normal[3 * i];
      const double slope = dot(eye.axes * Vec3<double>{n[0], n[1], n[2]}, sky.sun);
      if (slope < 0.05) return;  // the dark side
      (shade < 0 ? in_sun : in_shadow) += 1;
      EXPECT_NEAR(wide.rgb[3 * i], byte_of(shade < 0 ? slope : 0.0), 1)
          << "scene " << k << ", pixel " << i << ", shade " << shade;
    });
  }
  EXPECT_GT(in_sun, 5000);
  EXPECT_GT(in_shadow, 500);
}

TEST_F(ShadesTest, TheSkyChangesFromTheHorizonToTheZenith) {
  sky.zenith = {0.0f, 0.0f, 1.0f};
  sky.horizon = {1.0f, 1.0f, 1.0f};
  shapes.clear();
  camera.draw({{0.0, 0.0, 2.0}, looking(0.0, 0.0, 0.0)}, shapes, sky);
  EXPECT_EQ(red_at(16, 16), 255);
  EXPECT_EQ(red_at(32, 16), 255) << "below the horizon";
  camera.draw({{0.0, 0.0, 2.0}, looking(0.0, -0.5 * kPi, 0.0)}, shapes, sky);
  EXPECT_EQ(red_at(16, 16), 0);
}

TEST_F(ShadesTest, HazeMixesTheHorizonInByTheDepth) {
  shapes[0].paint.color = {0.0f, 0.0f, 0.0f};
  sky.horizon = {0.8f, 0.8f, 0.8f};
  look_down();  // from a depth of 2 m
  EXPECT_EQ(red_at(16, 16), 0);
  for (const double haze : {0.5, 2.0, 30.0}) {
    sky.haze = static_cast<float>(haze);
    look_down();
    EXPECT_NEAR(red_at(16, 16), byte_of(0.8 * 4.0 / (4.0 + haze * haze)), 1);
  }
  sky.haze = 2.0f;
  shapes.clear();
  camera.draw({{0.0, 0.0, 2.0}, looking(0.0, -0.5 * kPi, 0.0)}, shapes, sky);
  EXPECT_EQ(red_at(16, 16), byte_of(static_cast<double>(sky.zenith[0])));  // the sky stays
}

TEST_F(ShadesTest, PackedColorsAreThoseOfTheWantedTiles) {
  RandomScenes random(9);
  shapes = random.scene(12);
  const Eye eye = random.eye(4.0);
  camera.draw(eye, shapes, sky);  // 3 x 9 tiles of 33 x 33 pixels
  std::vector<std::uint8_t> wanted(3 * 9);
  wanted[4] = wanted[7] = wanted[26] = 1;
  std::vector<std::uint32_t> packed(3 * kTilePixels);
  Frame frame;
  frame.tiles = wanted.data();
  frame.packed = packed.data();
  camera.renderer.draw(eye, shapes, sky, camera.scratch.data(), frame);
  const std::size_t columns[] = {1, 1, 2}, bands[] = {1, 2, 8};
  for (std::size_t tile = 0; tile < 3; ++tile) {
    for (std::size_t at = 0; at < kTilePixels; ++at) {
      const std::size_t x = 16 * columns[tile] + at % 16, y = 4 * bands[tile] + at / 16;
      if (x >= 33 || y >= 33) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_EQ(packed[tile * kTilePixels + at] >> (8 * c) & 255,
                  camera.rgb[3 * (33 * y + x) + c])
            << tile << " " << at;
      }
    }
  }
}

}  // namespace
}  // namespace skybody::testing
