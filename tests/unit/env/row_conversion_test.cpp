// Rows of learners: the rules of RowKernels, value by value, and the rows that a transition writes.
#include "core/env/row_conversion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/model/state_layout.h"
#include "core/physics/world/lane_values.h"
#include "tests/unit/env/small_plugins.h"

namespace skybody {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr double kGuard = -77.25;  // in places that must not be written
constexpr int kWidest = 9;         // values per row
/// No lane, single lanes, blocks of eight with holes, full blocks, all lanes.
constexpr std::uint32_t kMasks[] = {0u,          1u,          0x80000000u, 0x7fu,
                                    0xfeu,       0x00ff0100u, 0xff7ffeffu, 0x0ff00ff0u,
                                    0xff0000ffu, 0xffffffffu};

bool holds(std::uint32_t mask, int lane) { return ((mask >> lane) & 1u) != 0; }

/// A value of lane and index: inside and outside [-1, 1], zeros of both signs.
float value(int lane, int k) {
  const int n = (lane * 7 + k * 3) % 11;
  return n == 0 ? -0.0f : 0.3f * static_cast<float>(n - 5);
}

/// Calls check(kernels, lanes, mask, count) for all available combinations.
template <class Check>
void for_all(Check&& check) {
  for (const Isa isa : kIsas) {
    if (!machine_has(isa)) continue;
    const RowKernels kernels = row_kernels(isa);
    for (int count = 0; count <= kWidest; ++count) {
      SCOPED_TRACE(std::string(name(isa)) + ", " + std::to_string(count));
      for (const std::uint32_t mask : kMasks) check(kernels, kGroupLanes, mask, count);
      check(kernels, 1, 0u, count);
      check(kernels, 1, 1u, count);
    }
  }
}

// A row of 30 values: some lie in lanes, the others are copies of these.
TEST(RowKernels, WriteRowsOfWhichPartsAreCopies) {
  RowParts parts{
      30, {{0, 9}, {12, 1}, {14, 4}}, {{0, 9, 3}, {4, 13, 1}, {0, 18, 12 - 4}, {3, 26, 4}}, {}};
  parts.set_pieces();
  for (const Isa isa : kIsas) {
    if (!machine_has(isa)) continue;
    for (const int lanes : {1, kGroupLanes}) {
      for (const std::uint32_t mask : kMasks) {
        if (lanes == 1 && mask > 1) continue;
        SCOPED_TRACE(std::string(name(isa)) + ", " + std::to_string(mask));
        std::vector<double> values(static_cast<std::size_t>(30 * lanes), kNone);
        std::vector<float> rows(values.size(), static_cast<float>(kGuard));
        for (const ValueRun& run : parts.written) {
          for (int k = run.first; k < run.first + run.count; ++k) {
            for (int l = 0; l < lanes; ++l) {
              values[static_cast<std::size_t>(k * lanes + l)] = static_cast<double>(value(l, k));
            }
          }
        }
        if (lanes > 1) values[static_cast<std::size_t>(16 * lanes + 9)] = kNone;
        const std::uint32_t finite =
            row_kernels(isa).write_parts(mask, lanes, values.data(), parts, rows.data());
        EXPECT_EQ(finite, lanes > 1 ? mask & ~(1u << 9) : mask);
        for (int l = 0; l < lanes; ++l) {
          for (int k = 0; k < 30; ++k) {
            const float got = rows[static_cast<std::size_t>(l * 30 + k)];
            const float want =
                holds(mask, l) ? value(l, parts.source_of(k)) : static_cast<float>(kGuard);
            if (lanes > 1 && l == 9 && k == 16 && holds(mask, l)) continue;
            EXPECT_EQ(got, want) << "lane " << l << ", value " << k;
          }
        }
      }
    }
  }
}

TEST(RowKernels, ReadFiniteRowsOfTheMaskAlone) {
  for_all([](const RowKernels& kernels, int lanes, std::uint32_t mask, int count) {
    constexpr int kStride = kWidest + 2;
    std::vector<float> rows(static_cast<std::size_t>(kStride * lanes), kNone);
    std::uint32_t finite = 0;
    for (int l = 0; l < lanes; ++l) {
      if (!holds(mask, l)) continue;
      float* row = rows.data() + l * kStride;
      for (int k = 0; k < count; ++k) row[k] = value(l, k);
      if (l == 2 && count > 1)
        row[0] = row[1] = 3e38f;  // their sum is not finite, but each value is
      if (l == 9 && count > 0) row[count - 1] = kNone;
      if (l == 28 && count > 0) row[0] = -std::numeric_limits<float>::infinity();
      if (std::all_of(row, row + count, [](float x) { return std::isfinite(x); }))
        finite |= 1u << l;
    }
    std::vector<double> values(static_cast<std::size_t>(kWidest * lanes), kGuard);
    EXPECT_EQ(kernels.read_clipped_actions(mask, lanes, rows.data(), kStride, count, values.data()),
              finite);
    for (int k = 0; k < kWidest; ++k) {
      for (int l = 0; l < lanes; ++l) {
        const double read = values[static_cast<std::size_t>(k * lanes + l)];
        const double given = static_cast<double>(rows[static_cast<std::size_t>(l * kStride + k)]);
        const bool served = k < count && holds(finite, l);
        ASSERT_EQ(read, served ? std::clamp(given, -1.0, 1.0) : kGuard) << mask << ", lane " << l;
        ASSERT_EQ(std::signbit(read), std::signbit(served ? given : kGuard));
      }
    }
  });
}

TEST(RowKernels, WriteRowsOfTheMaskAlone) {
  for_all([](const RowKernels& kernels, int lanes, std::uint32_t mask, int count) {
    std::vector<double> values(static_cast<std::size_t>(kWidest * lanes), std::nan(""));
    std::uint32_t finite = 0;
    const auto at = [lanes](int k, int l) { return static_cast<std::size_t>(k * lanes + l); };
    for (int l = 0; l < lanes; ++l) {
      if (!holds(mask, l)) continue;
      bool good = true;
      for (int k = 0; k < count; ++k) {
        double& x = values[at(k, l)] = 0.1 * static_cast<double>(value(l, k));
        if (l == 3) x = 3e38;              // the sum of all overflows a float
        if (l == 20 && k == 0) x = 1e200;  // not finite as a float
        good = good && std::isfinite(static_cast<float>(x));
      }
      if (good) finite |= 1u << l;
    }
    std::vector<float> rows(static_cast<std::size_t>(count * lanes), static_cast<float>(kGuard));
    EXPECT_EQ(kernels.write(mask, lanes, values.data(), count, rows.data()), finite);
    EXPECT_EQ(kernels.are_finite(mask, lanes, values.data(), count), finite);
    for (int l = 0; l < lanes; ++l) {
      for (int k = 0; k < count; ++k) {
        const double x = holds(mask, l) ? values[at(k, l)] : kGuard;
        ASSERT_EQ(rows[static_cast<std::size_t>(l * count + k)], static_cast<float>(x)) << mask;
      }
    }
  });
}

TEST(RowKernels, ScaleCopyAndCountServeTheMaskAlone) {
  for_all([](const RowKernels& kernels, int lanes, std::uint32_t mask, int count) {
    std::vector<double> action(static_cast<std::size_t>(kWidest * lanes));
    const auto at = [lanes](int k, int l) { return static_cast<std::size_t>(k * lanes + l); };
    for (int k = 0; k < kWidest; ++k) {
      for (int l = 0; l < lanes; ++l) action[at(k, l)] = 0.3 * static_cast<double>(value(l, k));
    }
    std::vector<double> low(kWidest), high(kWidest), command(action.size(), kGuard), copy = command;
    for (std::size_t k = 0; k < kWidest; ++k) low[k] = 0.1 * static_cast<double>(k), high[k] = 7.3;
    std::vector<std::uint64_t> words(static_cast<std::size_t>(lanes), 5);
    kernels.scale(mask, lanes, action.data(), count, low.data(), high.data(), command.data());
    kernels.count(mask, words.data());
    if (lanes == kGroupLanes) kernels.copy(mask, action.data(), count, copy.data());
    for (int l = 0; l < lanes; ++l) {
      ASSERT_EQ(words[static_cast<std::size_t>(l)], holds(mask, l) ? 6u : 5u);
      for (int k = 0; k < kWidest; ++k) {
        const auto n = static_cast<std::size_t>(k);
        const double a = action[at(k, l)];
        const bool served = holds(mask, l) && k < count;
        const double scaled = low[n] + 0.5 * (a + 1.0) * (high[n] - low[n]);
        ASSERT_EQ(command[at(k, l)], served ? scaled : kGuard) << mask << ", lane " << l;
        ASSERT_EQ(copy[at(k, l)], served && lanes > 1 ? a : kGuard) << mask << ", lane " << l;
      }
    }
  });
}

TEST(RowKernels, FillTheMaskAlone) {
  for_all([](const RowKernels& kernels, int lanes, std::uint32_t mask, int count) {
    const double values[] = {0.0, std::numeric_limits<double>::infinity(), -3.5};
    std::vector<double> to(static_cast<std::size_t>(count * lanes), kGuard);
    kernels.fill(mask, lanes, values, 3, count, to.data());
    for (int k = 0; k < count; ++k) {
      for (int l = 0; l < lanes; ++l) {
        EXPECT_EQ(to[static_cast<std::size_t>(k * lanes + l)],
                  holds(mask, l) ? values[k % 3] : kGuard);
      }
    }
  });
}

TEST(RowKernels, FindMultiplesOfAPeriodExactly) {
  constexpr std::uint64_t kLarge = std::uint64_t{1} << 51;
  for_all([](const RowKernels& kernels, int lanes, std::uint32_t mask, int) {
    for (const std::uint64_t period : {1ull, 2ull, 3ull, 7ull, 10ull, 49ull, 1000ull, 999983ull}) {
      for (const std::uint64_t start : {std::uint64_t{0}, 5 * period, kLarge - kLarge % period}) {
        std::vector<std::uint64_t> counts;
        std::uint32_t expected = 0;
        for (int l = 0; l < lanes; ++l) {
          counts.push_back(start + static_cast<std::uint64_t>(l));
          if (holds(mask, l) && counts.back() % period == 0) expected |= 1u << l;
        }
        EXPECT_EQ(kernels.multiples(mask, counts.data(), static_cast<double>(period)), expected)
            << period << " from " << start;
      }
    }
  });
}

TEST(RowKernels, EndByTaskOrHorizon) {
  for_all([](const RowKernels& kernels, int lanes, std::uint32_t mask, int count) {
    const auto horizon = static_cast<std::uint64_t>(count);  // 0: none
    const auto n = static_cast<std::size_t>(lanes);
    std::vector<std::uint64_t> by_task(n), step(n), status(n, 99), rows(n, 98);
    for (std::size_t l = 0; l < n; ++l) by_task[l] = l % 5 + 64 * (l % 2), step[l] = l % 7;
    kernels.end(mask, by_task.data(), step.data(), horizon, status.data(), rows.data());
    for (std::size_t l = 0; l < n; ++l) {
      const bool over = horizon > 0 && step[l] >= horizon;
      const std::uint64_t ends =
          (by_task[l] & (kTerminated | kTruncated)) | (over ? std::uint64_t{kTruncated} : 0);
      ASSERT_EQ(status[l], holds(mask, static_cast<int>(l)) ? ends : 99u);
      ASSERT_EQ(rows[l], holds(mask, static_cast<int>(l)) ? ends : 98u);
    }
  });
}

// --- transitions ---------------------------------------------------------------------------------

/// The observation of Watch, two robots' own rewards, and an info value.
class Team : public test::Watch {
 public:
  void configure(const Setup& setup) override {
    test::Watch::configure(setup);
    setup.robot_rewards();
    setup.info("speed", "m/s", 1);
  }
  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>& s, Evaluation<Real>& out) const {
    test::Watch::evaluate(env, s, out);
    for (int r = 0; r < 2; ++r) out.set_reward(r, env.body(r).position.z * Real(r + 2.0));
    out.info.set(0, env.body(0).velocity.z);
  }
};

std::unique_ptr<CompiledScenario> two_robots(test::InProcessFactory& factory) {
  factory.add<test::Direct>("direct");
  factory.add<Team>("team");
  Scenario s;
  s.name = "test";
  s.stepping.horizon = 4;
  s.contact.ground = false;
  for (const char* name : {"left", "right"}) {
    RobotUse robot;
    robot.name = name;
    robot.model = test::quadrotor();
    robot.pose.position = {name[0] == 'l' ? 0.0 : 5.0, 0.0, 1.0};
    robot.controllers.push_back(factory.use("direct", "direct"));
    s.robots.push_back(robot);
  }
  s.task = factory.use("team", "task");
  return std::make_unique<CompiledScenario>(std::move(s), factory);
}

/// A flight with all kinds of rows, with guard values in them and after them.
struct GuardedFlight : test::Flight {
  GuardedFlight(const CompiledScenario& compiled, int lanes)
      : Flight(compiled, lanes),
        agent(static_cast<std::size_t>(2 * lanes)),
        info(static_cast<std::size_t>(lanes)) {}
  Rows guarded() {
    for (auto* column : {&observation, &reward, &agent, &info}) {
      std::fill(column->begin(), column->end(), static_cast<float>(kGuard));
    }
    std::fill(status.begin(), status.end(), std::uint64_t{77});
    return {observation.data(), reward.data(), status.data(), agent.data(), info.data()};
  }
  /// All rows of a lane.
  std::vector<float> row(int lane) const {
    std::vector<float> out;
    const auto take = [&](const std::vector<float>& column, int width) {
      const auto from = column.begin() + lane * width;
      out.insert(out.end(), from, from + width);
    };
    take(observation, env.observation_size());
    take(reward, 1);
    take(agent, 2);
    take(info, 1);
    out.push_back(static_cast<float>(status[static_cast<std::size_t>(lane)]));
    return out;
  }
  std::vector<float> agent, info;
};

/// Actions of one lane in a step; not finite in some lanes and steps.
std::vector<float> actions_of(int lane, int step) {
  std::vector<float> actions(8, 0.02f * static_cast<float>((lane + step) % 7));
  if (lane == 5 && step == 2) actions[3] = kNone;
  return actions;
}

TEST(Rows, OfAMaskAreThoseOfLanesAloneAndNoOthersAreTouched) {
  for (const std::uint32_t mask : kMasks) {
    test::InProcessFactory factory;
    const auto env = two_robots(factory);
    GuardedFlight group(*env, kGroupLanes);
    env->reset(group.group, *group.work, ~0u, group.guarded());
    std::vector<std::unique_ptr<GuardedFlight>> alone;
    for (int l = 0; l < kGroupLanes; ++l) {
      alone.push_back(std::make_unique<GuardedFlight>(*env, 1));
      GuardedFlight& one = *alone.back();
      env->initialize(one.group, 0, 1, static_cast<std::uint64_t>(l));
      env->reset(one.group, *one.work, 1u, one.guarded());
      ASSERT_EQ(group.row(l), one.row(0));
    }
    const auto compare = [&](int step) {
      for (int l = 0; l < kGroupLanes; ++l) {
        GuardedFlight& one = *alone[static_cast<std::size_t>(l)];
        if (!holds(mask, l)) static_cast<void>(one.guarded());
        ASSERT_EQ(group.row(l), one.row(0)) << mask << ", lane " << l << ", step " << step;
        ASSERT_EQ(group.group.save(l), one.group.save(0)) << mask << ", lane " << l;
      }
    };
    for (int step = 0; step < 6; ++step) {
      std::vector<float> actions(8 * kGroupLanes, kNone);
      for (int l = 0; l < kGroupLanes; ++l) {
        if (!holds(mask, l)) continue;
        const std::vector<float> row = actions_of(l, step);
        std::copy(row.begin(), row.end(), actions.begin() + 8 * l);
        GuardedFlight& one = *alone[static_cast<std::size_t>(l)];
        if (step == 3 && l == 17) one.group.writable(env->layout().u, 1u)[2] = 1e200;
        env->step(one.group, *one.work, 1u, row.data(), 8, one.guarded());
      }
      if (step == 3 && holds(mask, 17)) {
        group.group.writable(env->layout().u, 1u << 17)[2 * kGroupLanes + 17] = 1e200;
      }
      env->step(group.group, *group.work, mask, actions.data(), 8, group.guarded());
      compare(step);
    }
    for (int l = 0; l < kGroupLanes; ++l) {
      GuardedFlight& one = *alone[static_cast<std::size_t>(l)];
      if (holds(mask, l)) env->reset(one.group, *one.work, 1u, one.guarded());
    }
    env->reset(group.group, *group.work, mask, group.guarded());
    compare(-1);
  }
}

TEST(Rows, AnAgentsRewardIsItsOwnAndZeroWhereThereIsAFault) {
  test::InProcessFactory factory;
  const auto env = two_robots(factory);
  GuardedFlight flight(*env, kGroupLanes);
  env->reset(flight.group, *flight.work, ~0u, flight.guarded());
  EXPECT_EQ(flight.agent[0], 0.0f);
  std::vector<float> actions(8 * kGroupLanes, 0.0f);
  actions[8 * 4] = kNone;
  env->step(flight.group, *flight.work, ~0u, actions.data(), 8, flight.guarded());
  EXPECT_EQ(flight.agent[2 * 3], 2.0f * flight.observation[4 * 3]);
  EXPECT_FLOAT_EQ(flight.agent[2 * 3 + 1], 3.0f * flight.observation[4 * 3]);
  EXPECT_EQ(flight.agent[2 * 4], 0.0f);
  EXPECT_EQ(flight.agent[2 * 4 + 1], 0.0f);
  EXPECT_EQ(flight.status[4], kTruncated | kFault | kBadAction);
}

TEST(Groups, HaveOneLaneOrAll) {
  test::InProcessFactory factory;
  const auto env = two_robots(factory);
  EXPECT_THROW(env->make_state(8), std::logic_error);
}

}  // namespace
}  // namespace skybody
