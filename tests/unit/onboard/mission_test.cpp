#include "onboard/mission.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "onboard/about.h"
#include "onboard/needs.h"
#include "tests/unit/onboard/hover_mission.h"

namespace skybody::onboard {
namespace {

TEST(Mission, HasTheSameBytesAfterItWasReadAndWritten) {
  Mission mission = hover_mission();
  const std::string bytes = to_bytes(mission);
  Mission again = from_bytes(bytes);
  EXPECT_EQ(to_bytes(again), bytes);
  EXPECT_EQ(again.vehicle().name, std::string("quad"));
  EXPECT_DOUBLE_EQ(again.period(), 0.01);
  EXPECT_DOUBLE_EQ(again.mass(), kMass);
  EXPECT_NEAR(again.largest_thrust(), kMostThrust, 1e-12);  // a sum of four
}

TEST(Mission, RefusesFilesThatAreCutOrChanged) {
  Mission mission = hover_mission();
  const std::string bytes = to_bytes(mission);
  for (std::size_t size = 0; size < bytes.size(); size += 97) {
    EXPECT_THROW(from_bytes(bytes.substr(0, size)), Error) << size;
  }
  for (std::size_t at = 0; at < bytes.size(); at += 211) {
    if (at >= 12 && at < 16) continue;  // not used
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 0x10);
    EXPECT_THROW(from_bytes(changed), Error) << at;
  }
}

TEST(Mission, RefusesSizesThatDoNotFit) {
  Mission mission = hover_mission();
  mission.policy.layers[0].bias.pop_back();
  EXPECT_THROW(from_bytes(to_bytes(mission)), Error);
  mission = hover_mission();
  mission.robot = 3;
  EXPECT_THROW(from_bytes(to_bytes(mission)), Error);
  mission = hover_mission();
  mission.actions[0].first = 2;
  EXPECT_THROW(from_bytes(to_bytes(mission)), Error);
}

TEST(Mission, NeedsOnlyTheBaseForHover) {
  const Mission mission = hover_mission();
  const Needs needs = find_needs(mission);
  EXPECT_TRUE(needs.bodies.empty());
  EXPECT_TRUE(needs.unknown.empty());
  EXPECT_FALSE(needs.imu);
  EXPECT_NE(about(mission, needs).find("position_error"), std::string::npos);
}

TEST(Mission, RefusesLinesThatAreNoGates) {
  const Mission mission = hover_mission();
  const std::string file = testing::TempDir() + "/gates.txt";
  for (const char* line : {"1 2 3\n", "1 2 3 nan\n", "1 2 x 4\n", "\n"}) {
    std::ofstream(file) << line;
    EXPECT_THROW(read_gates(file, mission), Error) << line;
  }
  std::ofstream(file) << "# x y z yaw\n1 2 3 0\n4 5 6 3.14 2 1\n";
  const auto gates = read_gates(file, mission);
  ASSERT_EQ(gates.size(), 2u);
  EXPECT_DOUBLE_EQ(gates[1][7], 2.0);
}

}  // namespace
}  // namespace skybody::onboard
