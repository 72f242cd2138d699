#include "core/base/simd/lane_mask.h"

#include <gtest/gtest.h>

#include <vector>

namespace skybody {
namespace {

TEST(Octets, AreThoseThatAMaskHoldsWhole) {
  EXPECT_EQ(whole_octets(0xffffffffu), 0xffffffffu);
  EXPECT_EQ(whole_octets(0xff7ffeffu), 0xff0000ffu);
  EXPECT_EQ(whole_octets(0xff000000u), 0xff000000u);
  EXPECT_EQ(whole_octets(0x0ff00ff0u),
            0u);  // eight consecutive lanes, but from two blocks of eight
  EXPECT_EQ(whole_octets(0u), 0u);
}

TEST(Octets, AreVisitedByTheirFirstLane) {
  std::vector<int> firsts, lanes;
  each_octet(0xff0000ffu, [&](int first) { firsts.push_back(first); });
  EXPECT_EQ(firsts, (std::vector<int>{0, 24}));
  each_lane(0x80000005u, [&](int lane) { lanes.push_back(lane); });
  EXPECT_EQ(lanes, (std::vector<int>{0, 2, 31}));
}

TEST(Octets, FirstLanesReachFromNoneToAll) {
  EXPECT_EQ(first_lanes(0), 0u);
  EXPECT_EQ(first_lanes(9), 0x1ffu);
  EXPECT_EQ(first_lanes(32), 0xffffffffu);
}

}  // namespace
}  // namespace skybody
