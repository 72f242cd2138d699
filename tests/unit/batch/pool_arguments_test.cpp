// Calls that a Pool refuses; a refusal leaves the Pool unchanged.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/unit/batch/small_env.h"

namespace skybody {
namespace {

using test::actions_of;
using test::begin;
using test::small_env;
using testing::HasSubstr;
using testing::ThrowsMessage;
using Ids = std::vector<std::int32_t>;

TEST(Options, OutOfRangeAreRefusedWithValueRangeAndRemedy) {
  const auto compiled = small_env();
  const auto make = [&](const PoolOptions& options) { Pool envs(compiled, options); };
  EXPECT_THAT([&] { make({.envs = 0}); },
              ThrowsMessage<Error>(HasSubstr("number of environments is 0; allowed: 1 ...")));
  EXPECT_THAT([&] { make({.envs = -3}); },
              ThrowsMessage<Error>(HasSubstr("number of environments is -3")));
  EXPECT_THAT([&] { make({.envs = 4, .batch = 5}); },
              ThrowsMessage<Error>(HasSubstr("batch is 5; allowed: 0 ... 4")));
  EXPECT_THAT([&] { make({.envs = 4, .batch = -1}); },
              ThrowsMessage<Error>(HasSubstr("batch is -1")));
  EXPECT_THAT([&] { make({.envs = 4, .threads = -1}); },
              ThrowsMessage<Error>(HasSubstr("threads is -1")));
}

TEST(Options, ZeroMeansAllEnvironmentsInABatchAndAThreadPerProcessor) {
  Pool envs(small_env(), {.envs = 3});
  EXPECT_EQ(envs.batch(), 3);
  EXPECT_GE(envs.threads(), 1);
  EXPECT_LE(envs.threads(), 3);
}

class Refusal : public testing::Test {
 protected:
  Pool envs_{small_env(), {.envs = 4, .batch = 2, .threads = 2}};

  void expect_usable() {
    EXPECT_EQ(envs_.in_flight(), 0);
    envs_.send(actions_of({0, 1, 2, 3}, 1, 4));
    EXPECT_EQ(envs_.recv()->rows, 2);
    EXPECT_EQ(envs_.recv()->rows, 2);
  }
};

TEST_F(Refusal, StepBeforeReset) {
  EXPECT_THAT(
      [&] {
        envs_.send(actions_of({0, 1, 2, 3}, 1, 4));
      },
      ThrowsMessage<Error>(HasSubstr("environment 0 has not begun an episode")));
  begin(envs_);
  expect_usable();
}

TEST_F(Refusal, OfOneIdSendsNothing) {
  begin(envs_);
  EXPECT_THAT(
      [&] {
        envs_.send(actions_of({1, 2, 1}, 1, 4), Ids{1, 2, 1});
      },
      ThrowsMessage<Error>(HasSubstr("environment 1 is there twice")));
  EXPECT_THAT(
      [&] {
        envs_.send(actions_of({1, 4}, 1, 4), Ids{1, 4});
      },
      ThrowsMessage<Error>(HasSubstr("no environment 4; allowed: 0 ... 3")));
  EXPECT_THAT(
      [&] {
        envs_.send(actions_of({1, -1}, 1, 4), Ids{1, -1});
      },
      ThrowsMessage<Error>(HasSubstr("no environment -1")));
  expect_usable();
}

TEST_F(Refusal, ActionsOfAnotherSize) {
  begin(envs_);
  EXPECT_THAT([&] { envs_.send(std::vector<float>(15)); },
              ThrowsMessage<Error>(HasSubstr("actions has 15 values; expected 4 x 4")));
  EXPECT_THROW(envs_.send({}), Error);
  expect_usable();
}

TEST_F(Refusal, OfWhatIsInFlight) {
  begin(envs_);
  envs_.send(actions_of({2}, 1, 4), Ids{2});
  EXPECT_THAT(
      [&] {
        envs_.send(actions_of({0, 2}, 1, 4), Ids{0, 2});
      },
      ThrowsMessage<Error>(HasSubstr("environment 2 is still in flight")));
  EXPECT_THROW(envs_.send_reset(), Error);
  EXPECT_THROW(envs_.send_reset(std::vector<std::uint8_t>{0, 0, 1, 0}), Error);
  EXPECT_THROW(envs_.send_reset(std::uint64_t{5}), Error);
  EXPECT_THROW(envs_.save(), Error);
  EXPECT_THROW(envs_.restore({}), Error);
  EXPECT_THROW(envs_.fork(0, Ids{2}, false), Error);
  EXPECT_THROW(envs_.fork(2, Ids{0}, false), Error);
  EXPECT_THROW(envs_.param(0, "task.mode"), Error);
  EXPECT_EQ(envs_.in_flight(), 1);
  envs_.send_reset(std::vector<std::uint8_t>{1, 0, 0, 0});  // others may be reset meanwhile
  envs_.fork(1, Ids{3}, false);                             // and copied
  EXPECT_EQ(envs_.recv()->rows, 2);
  expect_usable();
}

TEST_F(Refusal, MasksAndForksOutOfRange) {
  EXPECT_THROW(envs_.send_reset(std::vector<std::uint8_t>{1, 1, 1}), Error);
  begin(envs_);
  EXPECT_THROW(envs_.fork(4, Ids{0}, false), Error);
  EXPECT_THROW(envs_.fork(0, Ids{1, 4}, false), Error);
  EXPECT_THROW(envs_.fork(0, Ids{-1}, true), Error);
  EXPECT_THROW(envs_.param(4, "task.mode"), Error);
  EXPECT_THROW(envs_.set_param(0, "task.mode", 5.0), Error);
  EXPECT_THROW(envs_.hash(), Error);  // no hash was kept
  expect_usable();
}

}  // namespace
}  // namespace skybody
