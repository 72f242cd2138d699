// Programs lay out the structures of public headers themselves. A new member would break those that
// were linked with an earlier release of the same major version (docs/compatibility.md).
#include <gtest/gtest.h>

#include <cstddef>

#include "skybody/learn.h"
#include "skybody/skybody.h"

namespace skybody {
namespace {

// Of version 1.0, on x86-64 with libstdc++. Raise one with the major version only.
TEST(PublicStructures, KeepTheirSizesWithinAMajorVersion) {
  EXPECT_EQ(sizeof(LoadOptions), 0u);
  EXPECT_EQ(sizeof(SimulationOptions), 0u);
  EXPECT_EQ(sizeof(SimulationPoolOptions), 0u);
  EXPECT_EQ(sizeof(PoolOptions), 0u);
  EXPECT_EQ(sizeof(Batch), 0u);
  EXPECT_EQ(sizeof(CompiledScenario), 0u);
  EXPECT_EQ(sizeof(StateLayout), 0u);
  EXPECT_EQ(sizeof(Scenario), 0u);
  EXPECT_EQ(sizeof(Simulation), 0u);
  EXPECT_EQ(sizeof(SimulationPool), 0u);
  EXPECT_EQ(sizeof(Pool), 0u);
  EXPECT_EQ(sizeof(PolicyFile), 0u);
  EXPECT_EQ(sizeof(learn::LearnerOptions), 0u);
  EXPECT_EQ(sizeof(learn::Hyperparameters), 0u);
  EXPECT_EQ(sizeof(learn::RolloutOptions), 0u);
}

}  // namespace
}  // namespace skybody
