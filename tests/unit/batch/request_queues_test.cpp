// Requests: parameter values that callers request while environments may be in flight.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include "tests/unit/batch/small_env.h"

namespace skybody {
namespace {

using test::ClosedGate;
using test::gate;
using test::small_env;
using ::testing::HasSubstr;

constexpr const char* kPath = "gravity[2]";
constexpr double kNominal = -9.81;

PoolOptions request_options(int threads, int batch, Order order = Order::kFixed) {
  return {
      .envs = 6, .batch = batch, .threads = threads, .order = order, .seed = 3, .keep_hash = true};
}

std::vector<ParamChange> set_to(double value) { return {{kPath, make_constant(value)}}; }
std::vector<ParamChange> drawn() {
  return {{kPath, make_uniform(0.9, 1.1), ChangeForm::kScale, false}};
}

/// One transition of all environments, with actions that climb slightly.
void step_all(Pool& envs) {
  const auto values = static_cast<std::size_t>(envs.envs() * envs.compiled().action_size());
  envs.send(std::vector<float>(values));
  while (envs.in_flight() > 0) envs.recv();
}
void reset_all(Pool& envs) {
  envs.send_reset();
  while (envs.in_flight() > 0) envs.recv();
}

TEST(Request, IsDoneWithTheNextTransitionThatIsSent) {
  Pool envs(small_env(), request_options(2, 6));
  reset_all(envs);
  const std::vector<std::int32_t> two = {1, 4};
  envs.request(set_to(-5.0), RequestTime::kNextStep, two);
  EXPECT_EQ(envs.param(1, kPath), kNominal) << "nothing was sent yet";
  step_all(envs);
  for (int env = 0; env < 6; ++env) {
    EXPECT_EQ(envs.param(env, kPath), env == 1 || env == 4 ? -5.0 : kNominal);
  }
}

TEST(Request, IsNotSeenByWhatIsInFlight) {
  Pool envs(small_env(), request_options(2, 3));
  Pool other(small_env(), request_options(1, 6));
  for (Pool* p : {&envs, &other}) reset_all(*p);
  envs.set_param(2, "task.mode", test::kWait);
  other.set_param(2, "task.mode", test::kWait);
  {
    const ClosedGate closed;
    const auto values = static_cast<std::size_t>(6 * envs.compiled().action_size());
    envs.send(std::vector<float>(values));
    while (gate.waiting == 0) std::this_thread::yield();
    envs.request(set_to(-5.0), RequestTime::kNextStep);
    ClosedGate::open();
    while (envs.in_flight() > 0) envs.recv();
  }
  step_all(other);
  EXPECT_EQ(envs.hash(), other.hash());
  other.request(set_to(-5.0), RequestTime::kNextStep);
  for (Pool* p : {&envs, &other}) step_all(*p);
  EXPECT_EQ(envs.param(2, kPath), -5.0);
  EXPECT_EQ(envs.hash(), other.hash());
}

TEST(Request, AtAResetIsDoneInTheNextEpisode) {
  for (const Autoreset autoreset :
       {Autoreset::kNextStep, Autoreset::kSameStep, Autoreset::kDisabled}) {
    PoolOptions options = request_options(1, 6);
    options.autoreset = autoreset;
    Pool envs(small_env(), options);
    reset_all(envs);
    envs.request(set_to(-5.0), RequestTime::kNextReset);
    step_all(envs);
    for (int env = 0; env < 6; ++env) EXPECT_EQ(envs.param(env, kPath), kNominal);
    if (autoreset == Autoreset::kDisabled) {
      reset_all(envs);
    } else {
      for (int k = 0; k < 14; ++k) step_all(envs);  // an episode has at most twelve steps
    }
    for (int env = 0; env < 6; ++env) EXPECT_EQ(envs.param(env, kPath), -5.0);
  }
}

TEST(Request, BeforeAResetIsDoneInIt) {
  Pool envs(small_env(), request_options(1, 6));
  reset_all(envs);
  envs.request(set_to(-5.0), RequestTime::kNextStep);
  reset_all(envs);
  EXPECT_EQ(envs.param(3, kPath), -5.0);
}

TEST(Request, SeveralAreDoneInOrder) {
  Pool envs(small_env(), request_options(1, 6));
  reset_all(envs);
  for (const double value : {-1.0, -2.0, -3.0}) {
    envs.request(set_to(value), RequestTime::kNextStep);
  }
  step_all(envs);
  EXPECT_EQ(envs.param(0, kPath), -3.0);
}

TEST(Request, DrawsForEachEnvironmentItself) {
  Pool envs(small_env(), request_options(1, 6));
  reset_all(envs);
  envs.request(drawn(), RequestTime::kNextStep);
  step_all(envs);
  std::set<double> values;
  for (int env = 0; env < 6; ++env) {
    values.insert(envs.param(env, kPath));
    EXPECT_NEAR(envs.param(env, kPath), kNominal, 0.1 * std::abs(kNominal));
  }
  EXPECT_EQ(values.size(), 6u);
  envs.request(drawn(), RequestTime::kNextStep);
  step_all(envs);
  EXPECT_EQ(values.count(envs.param(0, kPath)), 0u) << "and another time something else";
}

TEST(Request, OfSeveralValuesSharesADrawWhereItSays) {
  Pool envs(small_env(), request_options(1, 6));
  reset_all(envs);
  envs.request(std::vector<ParamChange>{{"gravity", make_uniform(-1, 1), ChangeForm::kShift, true}},
               RequestTime::kNextStep);
  step_all(envs);
  EXPECT_EQ(envs.param(0, "gravity[0]"), envs.param(0, "gravity[1]"));
  EXPECT_NE(envs.param(0, "gravity[0]"), 0.0);
  envs.request(
      std::vector<ParamChange>{{"gravity", make_uniform(-1, 1), ChangeForm::kShift, false}},
      RequestTime::kNextStep);
  step_all(envs);
  EXPECT_NE(envs.param(0, "gravity[0]"), envs.param(0, "gravity[1]"));
}

/// Flies transitions of every environment, with requests at the same transition counts of each.
std::uint64_t fly_with_requests(Pool& envs, int transitions) {
  std::vector<int> count(static_cast<std::size_t>(envs.envs()), 0);
  const auto width = static_cast<std::size_t>(envs.compiled().action_size());
  envs.send_reset();
  while (envs.in_flight() > 0) {
    const auto batch = envs.recv();
    for (int k = 0; k < batch->rows; ++k) {
      const std::int32_t env = batch->env_id[static_cast<std::size_t>(k)];
      const int turn = count[static_cast<std::size_t>(env)]++;
      if (turn == transitions) continue;
      const std::vector<std::int32_t> one = {env};
      if ((turn + env) % 3 == 0) envs.request(drawn(), RequestTime::kNextStep, one);
      if ((turn + env) % 4 == 0) envs.request(drawn(), RequestTime::kNextReset, one);
      if ((turn + env) % 7 == 0) envs.randomize(RequestTime::kNextStep, one);
      envs.send(std::vector<float>(width), one);
    }
  }
  return envs.hash();
}

TEST(Request, GivesTheSameBitsWhateverTheThreadsBatchesAndOrder) {
  const auto compiled = small_env();
  Pool first(compiled, request_options(1, 6));
  const std::uint64_t hash = fly_with_requests(first, 60);
  for (const int threads : {1, 2, 4}) {
    for (const int batch : {1, 4, 6}) {
      for (const Order order : {Order::kFixed, Order::kArrival}) {
        Pool envs(compiled, request_options(threads, batch, order));
        EXPECT_EQ(fly_with_requests(envs, 60), hash) << threads << " threads, batches of " << batch;
      }
    }
  }
}

TEST(Request, OfAHundredThousandNoneIsLostAndNoneIsLate) {
  PoolOptions options = request_options(2, 16, Order::kArrival);
  options.envs = 64;
  Pool envs(small_env(), options);
  const auto width = static_cast<std::size_t>(envs.compiled().action_size());
  std::vector<double> asked(64, kNominal), sent(64, kNominal);
  Random<double> random{RandomKey{2026, 90}, 0, 0, derive_stream("request_test")};
  envs.send_reset();
  int made = 0;
  while (made < 100000) {
    for (int k = 0; k < 40; ++k, ++made) {  // while others fly
      const auto env = static_cast<std::int32_t>(random.integer(64));
      asked[static_cast<std::size_t>(env)] = random.uniform(-20.0, 0.0);
      envs.request(set_to(asked[static_cast<std::size_t>(env)]), RequestTime::kNextStep,
                   std::vector<std::int32_t>{env});
    }
    const auto batch = envs.recv();
    for (int k = 0; k < batch->rows; ++k) {
      const std::int32_t env = batch->env_id[static_cast<std::size_t>(k)];
      envs.send(std::vector<float>(width), std::vector<std::int32_t>{env});
      sent[static_cast<std::size_t>(env)] = asked[static_cast<std::size_t>(env)];
    }
  }
  while (envs.in_flight() > 0) envs.recv();
  for (int env = 0; env < 64; ++env) {
    EXPECT_EQ(envs.param(env, kPath), sent[static_cast<std::size_t>(env)]) << env;
  }
}

TEST(Request, UnderAnotherSeedBeginsWithNone) {
  Pool envs(small_env(), request_options(1, 6));
  reset_all(envs);
  envs.request(set_to(-5.0), RequestTime::kNextReset);
  envs.send_reset(std::uint64_t{9});
  while (envs.in_flight() > 0) envs.recv();
  EXPECT_EQ(envs.param(0, kPath), kNominal);
}

TEST(Request, IsRefusedWholeWhereItCannotBe) {
  Pool envs(small_env(), request_options(1, 6));
  reset_all(envs);
  const auto refusal = [&](std::vector<ParamChange> changes, std::vector<std::int32_t> ids = {}) {
    try {
      envs.request(changes, RequestTime::kNextStep, ids);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(refusal({{"gravty", make_constant(1.0)}}),
              HasSubstr("nothing randomizable is called `gravty`"));
  EXPECT_THAT(refusal({{"task.mode", make_uniform(1.0, 5.0)}}),
              HasSubstr("task.mode would be in [1, 5]: allowed is [0, 4]; ask for less"));
  EXPECT_THAT(refusal({{kPath, make_constant(-1.0)}, {"gravity", make_constant(0.0)}}),
              HasSubstr("`gravity` names gravity[2] a second time"));
  EXPECT_THAT(refusal(set_to(-1.0), {2, 6}), HasSubstr("6"));
  step_all(envs);
  for (int env = 0; env < 6; ++env) EXPECT_EQ(envs.param(env, kPath), kNominal);
}

TEST(ParamChange, IsReadAsItWasWritten) {
  const std::vector<ParamChange> changes = {
      {"a.b[0]", make_constant(0.1)},
      {"a", make_uniform(-1.0 / 3.0, 1e300), ChangeForm::kScale, true},
      {"a[*]", make_log_uniform(1e-9, 2.0), ChangeForm::kShift, false},
      {"a*", make_normal(1.0, 0.5, 0.0, 2.5)},
      {"c", make_choice({1.0, 2.0, 7.0}, {0.5, 0.25, 0.25})}};
  for (const ParamChange& change : changes) {
    const ParamChange again = read_param_change(change.text());
    EXPECT_EQ(again.text(), change.text());
    EXPECT_EQ(again.distribution.at(0.3), change.distribution.at(0.3));
  }
  for (const char* text : {"", "a", "a value each uniform 2 1", "a value each flat 1 2",
                           "a value each uniform 1 x", "a value each normal 0 1 -1"}) {
    EXPECT_THROW(read_param_change(text), Error) << text;
  }
}

}  // namespace
}  // namespace skybody
