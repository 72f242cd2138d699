// The hand-written loops that ./dev bench compares with give the engine's results.
#include <gtest/gtest.h>

#include "research/bench/limit/check.h"

namespace skybody::bench {
namespace {

TEST(Limit, FliesTheRuleOfTheEngineInItsLanes) { EXPECT_TRUE(limit::check(limit::all_loops())); }

}  // namespace
}  // namespace skybody::bench
