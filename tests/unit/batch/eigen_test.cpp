// Batches, actions and states as Eigen matrices: views of the same memory, rows of environments.
#include <gtest/gtest.h>
#include <skybody/eigen.h>

#include <numeric>
#include <vector>

#include "core/base/system/error.h"
#include "tests/unit/batch/small_env.h"

namespace skybody {
namespace {

using test::small_env;

TEST(Eigen, MapsOfABatchAreViewsOfItsRows) {
  Pool envs(small_env(), {.envs = 5, .threads = 1});
  envs.send_reset();
  const std::shared_ptr<const Batch> batch = envs.recv();
  const RowMap<const float> rows = observations(*batch);
  EXPECT_EQ(rows.data(), batch->observation.data());
  ASSERT_EQ(rows.rows(), 5);
  ASSERT_EQ(rows.cols(), envs.compiled().observation_size());
  for (int env = 0; env < 5; ++env) {
    for (int k = 0; k < rows.cols(); ++k) {
      EXPECT_EQ(rows(env, k), batch->observation[static_cast<std::size_t>(env * rows.cols() + k)]);
    }
  }
  EXPECT_EQ(rewards(*batch).data(), batch->reward.data());
  EXPECT_EQ(rewards(*batch).size(), 5);
  EXPECT_EQ(infos(*batch).cols(), envs.compiled().info_size());
  EXPECT_EQ(agent_rewards(*batch).rows(), 5);
  EXPECT_EQ(privileged(*batch).size(), 0);
}

TEST(Eigen, APartialBatchHasItsOwnNumberOfRows) {
  Pool envs(small_env(), {.envs = 5, .batch = 2, .threads = 1});
  envs.send_reset();
  EXPECT_EQ(observations(*envs.recv()).rows(), 2);
  EXPECT_EQ(rewards(*envs.recv()).size(), 2);
  EXPECT_EQ(rewards(*envs.recv()).size(), 1);
}

TEST(Eigen, ActionsAndStatesGoInAndOutWithoutACopy) {
  Pool envs(small_env(), {.envs = 3, .threads = 1});
  test::begin(envs);
  RowMatrix<float> actions(3, 4);
  actions << 0.1f, 0.2f, 0.3f, 0.4f, 0.0f, 0.0f, 0.0f, 0.0f, -0.1f, -0.2f, -0.3f, -0.4f;
  EXPECT_EQ(values_of(actions).data(), actions.data());
  envs.send(values_of(actions));
  envs.recv();
  RowMatrix<double> action(3, 4);
  envs.state("action", values_of(action));
  EXPECT_EQ(action.cast<float>(), actions);
}

TEST(Eigen, RowsOfPlainMemoryMayBeWrittenAndMustHaveTheirSize) {
  std::vector<double> values(6);
  std::iota(values.begin(), values.end(), 0.0);
  RowMap<double> rows = row_map(std::span(values), 2, 3);
  EXPECT_EQ(rows(1, 0), 3.0);
  rows.row(0).setConstant(9.0);
  EXPECT_EQ(values[2], 9.0);
  EXPECT_THROW(row_map(std::span(values), 2, 4), Error);
  const std::vector<double>& fixed = values;
  EXPECT_EQ(row_map(std::span(fixed), 3, 2)(2, 1), 5.0);
}

}  // namespace
}  // namespace skybody
