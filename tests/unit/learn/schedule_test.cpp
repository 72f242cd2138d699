// Progress of a training and its step size; distances reported by tasks.
#include "learn/common/schedule.h"

#include <gtest/gtest.h>

#include "core/assemble/compile_scenario.h"
#include "learn/position_error.h"
#include "tests/unit/learn/small_team.h"

namespace skybody::learn {
namespace {

TEST(Schedule, ProgressGoesToOneAndStays) {
  EXPECT_EQ(progress(0, 100), 0.0);
  EXPECT_EQ(progress(25, 100), 0.25);
  EXPECT_EQ(progress(130, 100), 1.0);
  EXPECT_EQ(progress(130, 0), 0.0);  // without an end
}

TEST(Schedule, LearningRateIsLinearDownToItsLastShare) {
  Hyperparameters hyper;
  hyper.learning_rate = 8e-3;
  hyper.final_learning_rate = 0.25;
  EXPECT_DOUBLE_EQ(learning_rate(hyper, 0.0), 8e-3);
  EXPECT_DOUBLE_EQ(learning_rate(hyper, 0.5), 5e-3);
  EXPECT_DOUBLE_EQ(learning_rate(hyper, 1.0), 2e-3);
}

TEST(PositionError, IsFoundByTheNameThatTheTaskGives) {
  const PositionError small = find_position_error(*test::small_team());
  EXPECT_TRUE(small.is_told());
  EXPECT_EQ(small.count, 1);
  const auto hover = compile_scenario({"hover", {}, {}});
  const PositionError error = find_position_error(*hover);
  int first = 0;
  for (const Channel& channel : hover->info_channels()) {
    if (channel.name == "position_error") break;
    first += channel.count;
  }
  EXPECT_EQ(error.first, first);
  const char* watch = "task={plugin: watch, parameters: {link: base_link}}";
  EXPECT_FALSE(find_position_error(*compile_scenario({"hover", {watch}, {}})).is_told());
}

TEST(PositionError, IsTheNormOfItsValues) {
  const float info[] = {9.0f, 2.0f, -3.0f, 6.0f, 9.0f};
  const PositionError error{1, 3};
  EXPECT_DOUBLE_EQ(error.of(info), 7.0);
}

}  // namespace
}  // namespace skybody::learn
