// `skybody bench`: tests the format of its output, not the speed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/yaml/config_tree.h"
#include "tests/integration/process.h"

namespace skybody::test {
namespace {

using testing::HasSubstr;

double number(const ConfigNode& json, const char* key) {
  const ConfigNode* value = json.find(key);
  EXPECT_NE(value, nullptr) << key;
  return value == nullptr ? 0.0 : std::stod(value->scalar);
}

TEST(Bench, PrintsATable) {
  const Outcome outcome =
      run_skybody({"bench", "hover", "--envs", "4", "--threads", "2", "--seconds", "0.1"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  for (const char* line :
       {"hover: 4 environments, batches of 4 (fixed), 2 threads", "env steps/s", "physics steps/s",
        "per thread", "share of physics", "physics steps near contact", "resets", "faults"}) {
    EXPECT_THAT(outcome.out, HasSubstr(line));
  }
}

TEST(Bench, PrintsJsonWhoseNumbersFitTogether) {
  for (const char* actions : {"hold", "zero", "random"}) {
    const Outcome outcome =
        run_skybody({"bench", "hover", "--envs", "6", "--threads", "2", "--batch", "2", "--order",
                     "arrival", "--actions", actions, "--seconds", "0.1", "--json", "--set",
                     "stepping.horizon=20", "--set", "stepping.action_repeat=3"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    Diagnostics diagnostics;
    const auto json = parse_yaml(outcome.out, "bench", diagnostics);  // JSON is YAML
    ASSERT_TRUE(json.has_value()) << diagnostics.to_string() << outcome.out;
    EXPECT_EQ(number(*json, "envs"), 6.0);
    EXPECT_EQ(number(*json, "batch"), 2.0);
    EXPECT_EQ(number(*json, "threads"), 2.0);
    EXPECT_EQ(json->find("order")->scalar, "arrival");
    EXPECT_EQ(json->find("actions")->scalar, actions);
    const double steps = number(*json, "env_steps"), rate = number(*json, "env_steps_per_second");
    EXPECT_GT(steps, 0.0);
    EXPECT_DOUBLE_EQ(rate, steps / number(*json, "seconds"));
    EXPECT_GT(number(*json, "processor_seconds"), 0.0);
    EXPECT_DOUBLE_EQ(number(*json, "physics_steps_per_second"), 3.0 * rate);
    EXPECT_DOUBLE_EQ(number(*json, "env_steps_per_second_per_thread"), rate / 2.0);
    EXPECT_EQ(number(*json, "near_share"), 0.0);
    EXPECT_EQ(number(*json, "faults"), 0.0);
  }
}

TEST(Bench, CountsResetsApartFromSteps) {
  // A horizon of one step: every second transition is a reset.
  const Outcome outcome =
      run_skybody({"bench", "hover", "--envs", "2", "--threads", "1", "--seconds", "0.1", "--json",
                   "--set", "stepping.horizon=1"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  Diagnostics diagnostics;
  const auto json = parse_yaml(outcome.out, "bench", diagnostics);
  ASSERT_TRUE(json.has_value());
  // All environments step and reset together: the counts differ by one round at most.
  EXPECT_NEAR(number(*json, "resets"), number(*json, "env_steps"), 2.0);
}

}  // namespace
}  // namespace skybody::test
