// An observer of a Pool cannot make its caller lose data.
#include "core/batch/observer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "core/base/system/error.h"
#include "tests/unit/batch/small_env.h"

namespace skybody {
namespace {

using test::actions_of;
using test::begin;
using test::small_env;

/// Throws once when it is notified.
class FullDisk : public PoolObserver {
 public:
  void received(const Batch&, const EnvironmentStates&) override {
    if (++calls == 2) throw Error("no space left");
  }
  int calls = 0;
};

TEST(Observer, ThatFailsLosesNoRowsAndIsReportedByTheNextCall) {
  Pool envs(small_env(), {.envs = 2, .threads = 1});
  Pool alone(small_env(), {.envs = 2, .threads = 1});
  const auto disk = std::make_shared<FullDisk>();
  envs.observe(disk);
  begin(envs);
  begin(alone);
  const std::vector<float> actions = actions_of(std::vector<std::int32_t>{0, 1}, 1, 4);
  envs.send(actions);
  alone.send(actions);
  const auto rows = envs.recv(), expected = alone.recv();  // the observer throws here
  EXPECT_EQ(rows->observation, expected->observation);
  try {
    envs.send(actions);
    FAIL() << "nobody said that the observer failed";
  } catch (const StateError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("no space left"));
  }
  envs.send(actions);  // notified once
  alone.send(actions);
  EXPECT_EQ(envs.recv()->observation, alone.recv()->observation);
  EXPECT_EQ(disk->calls, 3);
}

}  // namespace
}  // namespace skybody
