// Lines over an image: their places, how they mix, and surfaces that hide them.
#include "render/lines.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/unit/render/scenes.h"

namespace skybody {
namespace {

using namespace testing;

constexpr int kWidth = 40, kHeight = 30;
constexpr std::uint8_t kUnder = 100;

/// A camera at the origin that looks along x: a point (d, y, z) is seen at column 20 - 20 y / d.
class LinesTest : public ::testing::Test {
 protected:
  /// The image of lines of white over grey, and surfaces at a depth [m].
  void draw(const std::vector<LinePoint>& points, float depth = 100.0f) {
    const std::vector<float> depths(kWidth * kHeight, depth);
    rgb_.assign(3 * kWidth * kHeight, kUnder);
    draw_lines({kWidth, kHeight, 20.0, 20.0, 20.0, 15.0}, {{}, looking(0.0, 0.0, 0.0)}, points,
               depths.data(), rgb_.data());
  }
  int at(int column, int row) const {
    return rgb_[static_cast<std::size_t>(3 * (row * kWidth + column))];
  }
  int changed() const {
    int count = 0;
    for (std::size_t i = 0; i < rgb_.size(); i += 3) count += rgb_[i] != kUnder ? 1 : 0;
    return count;
  }

 private:
  std::vector<std::uint8_t> rgb_;
};

LinePoint point(double x, double y, double z, float width = 2.0f, float opacity = 1.0f) {
  return {{x, y, z}, {1.0f, 1.0f, 1.0f}, opacity, width, false};
}

TEST_F(LinesTest, ALineCoversThePixelsOfItsWidth) {
  draw({point(2.0, 1.0, 0.0), point(2.0, -1.0, 0.0)});  // columns 10 to 30 between rows 14 and 15
  for (int column = 10; column < 30; ++column) {
    EXPECT_EQ(at(column, 14), 255);
    EXPECT_EQ(at(column, 15), 255);
  }
  EXPECT_EQ(changed(), 2 * 20);
  draw({point(2.0, 1.0, 0.0, 1.0f), point(2.0, -1.0, 0.0, 1.0f)});  // half of each row
  EXPECT_EQ(at(20, 14), 178);
  EXPECT_EQ(at(20, 15), 178);
}

TEST_F(LinesTest, NarrowAndFaintLinesAreFaint) {
  const double y = 0.05;  // the middle of row 14: 15 - 20 * 0.05 / 2
  draw({point(2.0, 1.0, y, 1.0f), point(2.0, -1.0, y, 1.0f)});
  EXPECT_EQ(at(20, 14), 255);
  draw({point(2.0, 1.0, y, 0.5f), point(2.0, -1.0, y, 0.5f)});
  EXPECT_EQ(at(20, 14), 178);  // 100 + 155 / 2, rounded
  draw({point(2.0, 1.0, y, 1.0f, 0.5f), point(2.0, -1.0, y, 1.0f, 0.5f)});
  EXPECT_EQ(at(20, 14), 178);
}

TEST_F(LinesTest, PartsOfALineMeetWithoutAGapOrASpot) {
  draw({point(2.0, 1.0, 0.3, 2.0f, 0.5f), point(2.0, -1.0, -0.3, 2.0f, 0.5f)});
  std::vector<int> whole;
  for (int row = 0; row < kHeight; ++row) whole.push_back(at(20, row));
  const int count = changed();
  draw({point(2.0, 1.0, 0.3, 2.0f, 0.5f), point(2.0, 0.013, 0.0039, 2.0f, 0.5f),
        point(2.0, -1.0, -0.3, 2.0f, 0.5f)});
  for (int row = 0; row < kHeight; ++row) {
    EXPECT_NEAR(at(20, row), whole[static_cast<std::size_t>(row)], 1) << row;  // rounding
  }
  EXPECT_EQ(changed(), count);
}

TEST_F(LinesTest, NearerSurfacesHideALine) {
  const std::vector<LinePoint> line{point(2.0, 1.0, 0.0), point(2.0, -1.0, 0.0)};
  draw(line, 1.99f);
  EXPECT_EQ(changed(), 0);
  draw(line, 2.0f);  // it lies on the surface
  EXPECT_EQ(changed(), 2 * 20);
}

TEST_F(LinesTest, ALineGoesOnBehindTheEyeUnseen) {
  draw({point(-2.0, 1.0, 0.0), point(-2.0, -1.0, 0.0)});
  EXPECT_EQ(changed(), 0);
  draw({point(4.0, 0.4, -0.4), point(-4.0, 0.4, -0.4)});  // to the lower left corner
  EXPECT_EQ(at(16, 18), 255);
  EXPECT_GT(changed(), 12);
  const int count = changed();
  draw({point(-4.0, 0.4, -0.4), point(4.0, 0.4, -0.4)});
  EXPECT_NEAR(changed(), count, 2);  // its ends
}

TEST_F(LinesTest, NoLineLeadsToAFirstPoint) {
  std::vector<LinePoint> line{point(2.0, 1.0, 0.0), point(2.0, -1.0, 0.0)};
  line[1].is_first = true;
  draw(line);
  EXPECT_EQ(changed(), 0);
  draw({point(2.0, 1.0, 0.0), point(2.0, 1.0, 0.0)});  // of no length
  EXPECT_EQ(changed(), 0);
}

TEST_F(LinesTest, PointsThatAreNoNumbersAreNotDrawn) {
  const double nan = std::nan("");
  draw({point(2.0, nan, 0.0), point(2.0, -1.0, 0.0), point(nan, 1.0, 0.0), point(2.0, 1e300, 0.0)});
  EXPECT_EQ(changed(), 0);
}

}  // namespace
}  // namespace skybody
