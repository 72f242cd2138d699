// Environments that wait for the rest of their lane group.
#include "core/batch/waiting_lanes.h"

#include <gtest/gtest.h>

#include <map>

namespace skybody {
namespace {

using Started = std::map<int, std::uint32_t>;

TEST(WaitingLanes, AreReleasedByGroupsWithAllLanesThatWait) {
  WaitingLanes waiting(3);
  waiting.hold(2, 1u);
  waiting.hold(0, 4u);
  waiting.hold(2, 2u);
  EXPECT_EQ(waiting.count(), 3);
  Started started;
  const auto start = [&](int group, std::uint32_t lanes) { started[group] = lanes; };
  waiting.release([](int group, std::uint32_t lanes) { return group == 2 && lanes == 3u; }, start);
  EXPECT_EQ(started, (Started{{2, 3u}}));
  EXPECT_EQ(waiting.count(), 1);
  waiting.hold(2, 8u);  // the group can be waiting again, without the lanes that have gone
  waiting.release([](int, std::uint32_t) { return true; }, start);
  EXPECT_EQ(started, (Started{{0, 4u}, {2, 8u}}));
  EXPECT_EQ(waiting.count(), 0);
}

TEST(WaitingLanes, TheFullestGroupIsReleasedAlone) {
  WaitingLanes waiting(2);
  waiting.hold(0, 1u);
  waiting.hold(1, 1u);
  waiting.hold(1, 16u);
  Started started;
  waiting.release_fullest([&](int group, std::uint32_t lanes) { started[group] = lanes; });
  EXPECT_EQ(started, (Started{{1, 17u}}));
  EXPECT_EQ(waiting.count(), 1);
}

}  // namespace
}  // namespace skybody
