// Depths, ranges, ids and normals against rays in double, and one result for all kernels.
#include "render/renderer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/render/scenes.h"

namespace skybody::testing {
namespace {

using ::testing::Each;

/// The goal for depths: 1e-5 of the depth, some 80 roundings of float.
constexpr double kRelative = 1e-5;
/// Directions this far from a pixel's centre may see another surface than its centre: farther than
/// the rounding of positions in float, 1e-6 of the distance.
constexpr double kEdge = 2e-4;
/// Cosine of the steepest view of a surface at which depths are compared: the error of a direction
/// in float is multiplied by its inverse.
constexpr double kSteepest = 0.1;

/// Hash of the images of AllKernelsGiveTheSameBits. It changes with the renderer's arithmetic only.
constexpr std::uint64_t kPinned = 9455702663575836432u;

constexpr Solid kSolids[] = {Solid::kBox, Solid::kSphere, Solid::kCylinder, Solid::kCapsule,
                             Solid::kPlane};

/// A pixel's view in double, if all directions around its centre see one smooth surface.
struct Smooth {
  bool is_smooth = false;
  Sight sight;
  Vec3<double> normal{0.0, 0.0, 0.0};  ///< camera axes
};

Smooth view_of(const std::vector<PlacedShape>& shapes, const Eye& eye, double x, double y) {
  const auto at = [&](double dx, double dy) {
    return sight_along(shapes, eye, x + dx, y + dy, 100.0);
  };
  const Sight middle = at(0.0, 0.0);
  const Sight around[] = {at(kEdge, 0.0), at(-kEdge, 0.0), at(0.0, kEdge), at(0.0, -kEdge)};
  for (const Sight& sight : around) {
    if (sight.shape != middle.shape) return {};
  }
  if (middle.shape < 0) return {true, middle};
  const auto point = [&](double dx, double dy, double depth) {
    return Vec3<double>{(x + dx) * depth, (y + dy) * depth, depth};
  };
  const Vec3<double> across =
      point(kEdge, 0.0, around[0].depth) - point(-kEdge, 0.0, around[1].depth);
  const Vec3<double> down =
      point(0.0, kEdge, around[2].depth) - point(0.0, -kEdge, around[3].depth);
  // A crease between the two directions bends the surface more than its curvature does.
  const double bend_x = around[0].depth + around[1].depth - 2.0 * middle.depth;
  const double bend_y = around[2].depth + around[3].depth - 2.0 * middle.depth;
  const bool is_creased = std::max(std::abs(bend_x), std::abs(bend_y)) > 1e-6 * middle.depth;
  const Vec3<double> out = cross(down, across);
  return {!is_creased, middle, out / norm(out)};
}

TEST(RendererTest, DepthsAreThoseOfRaysInDouble) {
  RandomScenes scenes(1);
  Camera camera(square_of(32));
  for (const Solid solid : kSolids) {
    int compared = 0;
    for (int k = 0; k < 300; ++k) {
      const std::vector<PlacedShape> shapes{scenes.shape(solid, 1.0)};
      const Eye eye = scenes.eye(4.0);
      camera.draw(eye, shapes);
      camera.each_pixel([&](std::size_t i, double x, double y) {
        const Smooth view = view_of(shapes, eye, x, y);
        if (!view.is_smooth) return;
        if (view.sight.shape < 0) {
          EXPECT_EQ(camera.depth[i], 100.0f);
          return;
        }
        if (contains(shapes[0], eye.position)) return;
        const double length = std::sqrt(x * x + y * y + 1.0);
        const double facing = -dot(view.normal, Vec3<double>{x, y, 1.0}) / length;
        if (facing < kSteepest) return;
        ++compared;
        EXPECT_NEAR(camera.depth[i], view.sight.depth, kRelative * view.sight.depth)
            << "solid " << static_cast<int>(solid) << ", scene " << k << ", facing " << facing;
        EXPECT_NEAR(camera.range[i], view.sight.depth * length,
                    kRelative * view.sight.depth * length);
      });
    }
    EXPECT_GT(compared, 1000) << "solid " << static_cast<int>(solid);
  }
}

TEST(RendererTest, TheNearestShapeIsSeen) {
  RandomScenes scenes(2);
  Camera camera(square_of(48));
  int compared = 0;
  for (int k = 0; k < 40; ++k) {
    const std::vector<PlacedShape> shapes = scenes.scene(30);
    const Eye eye = scenes.eye(5.0);
    camera.draw(eye, shapes);
    const bool is_inside = std::any_of(shapes.begin(), shapes.end(), [&](const PlacedShape& s) {
      return contains(s, eye.position);
    });
    if (is_inside) continue;
    camera.each_pixel([&](std::size_t i, double x, double y) {
      const Smooth view = view_of(shapes, eye, x, y);
      if (!view.is_smooth) return;
      ++compared;
      EXPECT_EQ(camera.instance[i], view.sight.shape + 1) << "scene " << k << ", pixel " << i;
      EXPECT_EQ(camera.label[i],
                static_cast<int>(view.sight.shape < 0 ? Label::kNothing : Label::kObstacle));
    });
  }
  EXPECT_GT(compared, 50000);
}

TEST(RendererTest, NormalsAreOrthogonalToTheSurface) {
  RandomScenes scenes(3);
  Camera camera(square_of(32));
  // Differences over 4e-4 of depths with errors of 1e-16, and the curvature of radii above 0.1 m.
  constexpr double kTolerance = 2e-3;
  for (const Solid solid : kSolids) {
    int compared = 0;
    for (int k = 0; k < 100; ++k) {
      const std::vector<PlacedShape> shapes{scenes.shape(solid, 1.0)};
      const Eye eye = scenes.eye(4.0);
      if (contains(shapes[0], eye.position)) continue;
      camera.draw(eye, shapes);
      camera.each_pixel([&](std::size_t i, double x, double y) {
        const Vec3<double> seen{camera.normal[3 * i], camera.normal[3 * i + 1],
                                camera.normal[3 * i + 2]};
        const Smooth view = view_of(shapes, eye, x, y);
        if (!view.is_smooth) return;
        if (view.sight.shape < 0) {
          EXPECT_EQ(norm(seen), 0.0);
          return;
        }
        const double facing = -dot(view.normal, Vec3<double>{x, y, 1.0});
        if (facing < kSteepest * std::sqrt(x * x + y * y + 1.0)) return;
        ++compared;
        EXPECT_LT(norm(seen - view.normal), kTolerance)
            << "solid " << static_cast<int>(solid) << ", scene " << k << ", pixel " << i;
      });
    }
    EXPECT_GT(compared, 500) << "solid " << static_cast<int>(solid);
  }
}

TEST(RendererTest, AllKernelsGiveTheSameBits) {
  std::vector<std::uint64_t> hashes;
  for (const KernelTable* table : all_kernels()) {
    RandomScenes scenes(4);
    Camera camera({75, 50, 40.0, 41.0, 37.0, 24.0}, 64, 30.0, *table);
    HashChain chain(1);
    for (int k = 0; k < 60; ++k) {
      const std::vector<PlacedShape> shapes = scenes.scene(k + 1);
      camera.draw(scenes.eye(k % 2 == 0 ? 5.0 : 1000.0 * k), shapes);
      camera.add_to(chain);
    }
    hashes.push_back(chain.value());
  }
  // The images of these scenes on every processor.
  EXPECT_THAT(hashes, Each(kPinned));
}

TEST(RendererTest, AnEyeInsideAWallSeesTheWallAtNoDistance) {
  Camera camera(square_of(20));
  for (const Solid solid : kSolids) {
    std::vector<PlacedShape> shapes{shape_at(Solid::kSphere, {3.0, 0.0, 0.0}, {0.5, 0.0, 0.0}),
                                    shape_at(solid, {0.0, 0.0, 0.0}, {0.5, 0.5, 0.5})};
    shapes[1].instance = 7;
    camera.draw({{0.1, 0.1, -0.1}, looking(0.0, 0.0, 0.0)}, shapes);
    EXPECT_THAT(camera.depth, Each(0.0f));
    EXPECT_THAT(camera.range, Each(0.0f));
    EXPECT_THAT(camera.instance, Each(7));
  }
}

TEST(RendererTest, SurfacesBeyondTheFarthestDepthAreNotSeen) {
  Camera camera(square_of(16), 8, 5.0);
  std::vector<PlacedShape> shapes{shape_at(Solid::kBox, {5.6, 0.0, 0.0}, {0.5, 9.0, 9.0})};
  const Eye eye{{0.0, 0.0, 0.0}, looking(0.0, 0.0, 0.0)};
  camera.draw(eye, shapes);
  EXPECT_THAT(camera.depth, Each(5.0f));
  EXPECT_THAT(camera.instance, Each(0));
  shapes[0].position.x = 5.4;
  camera.draw(eye, shapes);
  EXPECT_THAT(camera.depth, Each(::testing::FloatNear(4.9f, 1e-5f)));
  EXPECT_THAT(camera.instance, Each(1));
}

TEST(RendererTest, AnImageIsThePartOfALargerOne) {
  RandomScenes scenes(5);
  Camera large({64, 48, 30.0, 30.0, 32.0, 24.0}), part({21, 10, 30.0, 30.0, 32.0 - 19, 24.0 - 7});
  for (int k = 0; k < 20; ++k) {
    const std::vector<PlacedShape> shapes = scenes.scene(20);
    const Eye eye = scenes.eye(5.0);
    large.draw(eye, shapes);
    part.draw(eye, shapes);
    for (std::size_t row = 0; row < 10; ++row) {
      for (std::size_t column = 0; column < 21; ++column) {
        const std::size_t i = row * 21 + column, j = (row + 7) * 64 + column + 19;
        ASSERT_EQ(part.depth[i], large.depth[j]);
        ASSERT_EQ(part.instance[i], large.instance[j]);
        ASSERT_EQ(part.rgb[3 * i], large.rgb[3 * j]);
      }
    }
  }
}

TEST(RendererTest, TheEdgesOfABoxHaveNoHoles) {
  // The edges of the box lie exactly on the centres of pixels.
  Camera camera({65, 65, 32.0, 32.0, 32.5, 32.5});
  const std::vector<PlacedShape> shapes{
      shape_at(Solid::kBox, {2.0, 0.0, 0.0}, {0.5, 0.5, 0.5}, turned(0.0, 0.0, 0.25 * kPi))};
  for (int k = 0; k < 200; ++k) {
    const double angle = 0.01 * k;
    const SinCos<double> turn = sincos(angle);
    camera.draw({{2.0 - 2.0 * turn.cos, -2.0 * turn.sin, 0.0}, looking(0.0, 0.0, angle)}, shapes);
    for (std::size_t row = 26; row < 39; ++row) {
      for (std::size_t column = 26; column < 39; ++column) {
        ASSERT_EQ(camera.instance[row * 65 + column], 1) << "step " << k;
      }
    }
  }
}

}  // namespace
}  // namespace skybody::testing
