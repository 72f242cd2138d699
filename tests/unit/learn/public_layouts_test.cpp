// A program has the sizes of public structures compiled in. A new member would break programs that
// were built with an earlier release of the same major version (docs/compatibility.md).
#include <gtest/gtest.h>

#include "skybody/learn.h"
#include "skybody/skybody.h"

namespace skybody {
namespace {

// Of version 1.0, on x86-64 with libstdc++. Change a size only with the major version.
TEST(PublicStructures, KeepTheirSizesWithinAMajorVersion) {
  EXPECT_EQ(sizeof(LoadOptions), 208u);
  EXPECT_EQ(sizeof(SimulationOptions), 96u);
  EXPECT_EQ(sizeof(SimulationPoolOptions), 32u);
  EXPECT_EQ(sizeof(PoolOptions), 48u);
  EXPECT_EQ(sizeof(Batch), 456u);
  EXPECT_EQ(sizeof(CompiledScenario), 160u);
  EXPECT_EQ(sizeof(StateLayout), 432u);
  EXPECT_EQ(sizeof(Scenario), 656u);
  EXPECT_EQ(sizeof(Simulation), 24u);
  EXPECT_EQ(sizeof(SimulationPool), 80u);
  EXPECT_EQ(sizeof(Pool), 8u);
  EXPECT_EQ(sizeof(PolicyFile), 248u);
  EXPECT_EQ(sizeof(learn::LearnerOptions), 360u);
  EXPECT_EQ(sizeof(learn::Hyperparameters), 320u);
  EXPECT_EQ(sizeof(learn::RolloutOptions), 72u);
}

}  // namespace
}  // namespace skybody
