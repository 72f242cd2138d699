// Smooth images are those of the plain renderer, with the mean of 16 rays beside edges.
#include "render/smooth_renderer.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

#include "tests/unit/render/scenes.h"

namespace skybody {
namespace {

using namespace testing;

constexpr Pinhole kCoarse{70, 50, 40.0, 40.0, 35.0, 25.0};
constexpr Pinhole kFine{280, 200, 160.0, 160.0, 140.0, 100.0};

std::vector<std::uint8_t> smooth(const Eye& eye, const std::vector<PlacedShape>& shapes,
                                 const KernelTable& kernels = kernels_of(best_isa())) {
  const SmoothRenderer renderer(kCoarse, 64, 100.0, kernels);
  SmoothRenderer::Scratch scratch(renderer);
  std::vector<std::uint8_t> rgb(3 * 70 * 50);
  renderer.draw(eye, shapes, {}, scratch, rgb.data());
  return rgb;
}

/// Of the 16 rays of a pixel.
int mean_of(const Camera& fine, int x, int y, int color) {
  int sum = 8;
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) {
      sum += fine.rgb[static_cast<std::size_t>(3 * ((4 * y + j) * 280 + 4 * x + i) + color)];
    }
  }
  return sum / 16;
}

TEST(SmoothRendererTest, APixelIsThatOfItsRayOrTheMeanOf16) {
  RandomScenes random(1);
  for (int k = 0; k < 20; ++k) {
    const std::vector<PlacedShape> shapes = random.scene(12);
    const Eye eye = random.eye(4.0);
    Camera coarse(kCoarse), fine(kFine);
    coarse.draw(eye, shapes);
    fine.draw(eye, shapes);
    const std::vector<std::uint8_t> rgb = smooth(eye, shapes);
    for (int y = 0; y < 50; ++y) {
      for (int x = 0; x < 70; ++x) {
        const auto first = static_cast<std::size_t>(3 * (y * 70 + x));
        bool is_ray = true, is_mean = true;
        for (int c = 0; c < 3; ++c) {
          const std::size_t at = first + static_cast<std::size_t>(c);
          is_ray &= rgb[at] == coarse.rgb[at];
          is_mean &= rgb[at] == mean_of(fine, x, y, c);
        }
        ASSERT_TRUE(is_ray || is_mean) << k << " " << x << " " << y;
      }
    }
  }
}

TEST(SmoothRendererTest, AnEdgeIsAMean) {
  PlacedShape box = shape_at(Solid::kBox, {3.0, 0.0, 0.0}, {0.1, 1.0, 1.0});
  box.paint.color = {1.0f, 0.0f, 0.0f};
  const Eye eye{{0.0, 0.0, 0.0}, looking(0.1, 0.0, 0.0)};  // a little rolled
  Camera coarse(kCoarse), fine(kFine);
  coarse.draw(eye, {box});
  fine.draw(eye, {box});
  const std::vector<std::uint8_t> rgb = smooth(eye, {box});
  int edges = 0;
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x + 1 < 70; ++x) {
      const auto at = static_cast<std::size_t>(3 * (y * 70 + x));
      if (std::abs(coarse.rgb[at] - coarse.rgb[at + 3]) <= 10) continue;
      ++edges;
      ASSERT_EQ(rgb[at], mean_of(fine, x, y, 0));
      ASSERT_EQ(rgb[at + 3], mean_of(fine, x + 1, y, 0));
    }
  }
  EXPECT_GT(edges, 40);
}

TEST(SmoothRendererTest, AllKernelsDrawTheSame) {
  RandomScenes random(2);
  const std::vector<PlacedShape> shapes = random.scene(12);
  const Eye eye = random.eye(4.0);
  const std::vector<std::uint8_t> first = smooth(eye, shapes);
  for (const KernelTable* kernels : all_kernels()) EXPECT_EQ(smooth(eye, shapes, *kernels), first);
}

TEST(SmoothRendererTest, AShapeWithoutShadowLeavesTheGroundInTheSun) {
  const PlacedShape ground = shape_at(Solid::kPlane, {}, {});
  PlacedShape ball = shape_at(Solid::kSphere, {4.0, 0.0, 1.0}, {0.5, 0.5, 0.5});
  const Eye eye{{0.0, 0.0, 2.0}, looking(0.0, 0.3, 0.0)};
  const std::vector<std::uint8_t> with = smooth(eye, {ground, ball});
  ball.casts_shadow = false;
  const std::vector<std::uint8_t> without = smooth(eye, {ground, ball});
  int brighter = 0;
  for (std::size_t i = 0; i < with.size(); ++i) {
    EXPECT_GE(without[i], with[i]);
    brighter += without[i] > with[i] ? 1 : 0;
  }
  EXPECT_GT(brighter, 30);
}

}  // namespace
}  // namespace skybody
