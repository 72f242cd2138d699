// Dryden turbulence against MIL-F-8785C: scales and intensities by height, and the statistics of
// the continuous process at any period.
#include <cmath>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;

constexpr int kLanes = SKYBODY_GROUP_LANES;
constexpr std::uint32_t kAll = 0xffffffffu;
constexpr double kFoot = 0.3048;

/// Values of the standard for a height, with a mean wind of 10 m/s at 20 ft and 2 m/s at high
/// altitude.
struct Expected {
  double length, length_vertical, sigma, sigma_vertical;
};
Expected expected_at(double height) {
  const double feet = std::max(height / kFoot, 10.0);
  const Expected high{1750 * kFoot, 1750 * kFoot, 2.0, 2.0};
  if (feet >= 2000) return high;
  const double low = std::min(feet, 1000.0), base = 0.177 + 0.000823 * low;
  const Expected near{kFoot * low / std::pow(base, 1.2), kFoot * low, 1.0 / std::pow(base, 0.4),
                      1.0};
  const double above = std::max(0.0, (feet - 1000) / 1000);
  const auto mix = [&](double a, double b) { return a + above * (b - a); };
  return {mix(near.length, high.length), mix(near.length_vertical, high.length_vertical),
          mix(near.sigma, high.sigma), mix(near.sigma_vertical, high.sigma_vertical)};
}

class DrydenTest : public ::testing::Test {
 protected:
  DrydenTest() { world.add_quad("quad"); }

  static Parameters with(Parameters more) {
    more.insert({{"wind_at_20_feet", 10.0}, {"sigma", 2.0}});
    return more;
  }
  /// A full group with one environment per lane.
  static Group environments(const Instance& dryden) {
    Group g = dryden.group(kLanes);
    for (int l = 0; l < kLanes; ++l) {
      g.key[static_cast<std::size_t>(kLanes + l)] = static_cast<std::uint64_t>(l);
    }
    return g;
  }
  static void begin_episode(const Instance& dryden, Group& g) {
    for (std::uint64_t& episode : g.episode) ++episode;
    std::fill(g.physics_step.begin(), g.physics_step.end(), 0u);
    std::fill(g.buffer.begin(), g.buffer.end(), 0.0);
    dryden.call(Call::kReset, g, kAll);
  }
  static void apply(const Instance& dryden, Group& g, std::uint64_t period = 10) {
    std::vector<double>& wind = g.held[SKYBODY_HELD_WIND];
    std::fill(wind.begin(), wind.end(), 0.0);
    dryden.call(Call::kApply, g, kAll);
    for (std::uint64_t& step : g.physics_step) step += period;
  }
  /// Means over independent episodes of the product of buffer values at the first call and buffer
  /// values `lag` calls later, for each pair of words in the lists.
  static std::vector<double> products(const Instance& dryden, const std::vector<int>& first,
                                      const std::vector<int>& later, int lag) {
    Group g = environments(dryden);
    std::vector<double> sums(first.size(), 0.0);
    for (int e = 0; e < kEpisodes; ++e) {
      begin_episode(dryden, g);
      apply(dryden, g);
      const std::vector<double> start = g.buffer;
      for (int k = 0; k < lag; ++k) apply(dryden, g);
      for (std::size_t i = 0; i < sums.size(); ++i) {
        for (int l = 0; l < kLanes; ++l) {
          sums[i] +=
              start[static_cast<std::size_t>(first[i] * kLanes + l)] * g.at(g.buffer, later[i], l);
        }
      }
    }
    for (double& sum : sums) sum /= kEpisodes * kLanes;
    return sums;
  }
  static constexpr int kEpisodes = 1000;
  /// Four standard errors of the mean product of two unit normals with correlation `rho`, whose
  /// variance is 1 + rho^2, over all episodes and environments.
  static double tolerance(double rho) {
    return 4.0 * std::sqrt((1.0 + rho * rho) / (kEpisodes * kLanes));
  }

  PluginWorld world;
};

TEST_F(DrydenTest, GivesTheBitsOfDouble) {
  expect_same_bits("dryden", world, {{"period", 1}});
  expect_same_bits("dryden", world, {{"height", 450.0}, {"follows", true}, {"heading", 1.0}});
}

// The memo may hold values of another environment, time or history.
TEST_F(DrydenTest, BelievesNoMemoOfOthers) {
  const Instance dryden("dryden", world, with({{"airspeed", 20.0}}));
  Group a = environments(dryden), b = environments(dryden);
  for (std::uint64_t& seed : b.key) seed += 100;
  std::vector<std::vector<double>> fresh, stale;
  for (std::vector<std::vector<double>>* winds : {&fresh, &stale}) {
    std::vector<double> memo = a.memo;
    for (Group* g : {&a, &b}) {
      g->episode.assign(g->episode.size(), 1);
      begin_episode(dryden, *g);
      for (int k = 0; k < 5; ++k) {
        if (winds == &stale) g->memo = memo;
        apply(dryden, *g);
        if (winds == &fresh) std::fill(g->memo.begin(), g->memo.end(), 0.0);
        memo = g->memo;
        g->at(g->buffer, 4, k) += 1.0;  // as a restored state may contain
        winds->push_back(g->held[SKYBODY_HELD_WIND]);
      }
    }
  }
  EXPECT_EQ(fresh, stale);
}

TEST_F(DrydenTest, GivesLanesThatAreDueAtOtherStepsWhatTheyHaveAlone) {
  const Instance dryden("dryden", world, with({{"airspeed", 20.0}}));
  Group together = environments(dryden);
  begin_episode(dryden, together);
  std::vector<Group> alone;
  for (int l = 0; l < kLanes; ++l) alone.push_back(together.alone(l));
  for (int step = 0; step < 40; ++step) {
    std::uint32_t due = 0;
    for (int l = 0; l < kLanes; ++l) {
      const auto lane = static_cast<std::size_t>(l);
      // Lanes began one after another.
      together.physics_step[lane] = static_cast<std::uint64_t>(std::max(0, step - l));
      alone[lane].physics_step[0] = together.physics_step[lane];
      if (step < l || (step - l) % 10 != 0) continue;
      due |= 1u << l;
      dryden.call(Call::kApply, alone[lane], 1);
    }
    dryden.call(Call::kApply, together, due);
  }
  for (int l = 0; l < kLanes; ++l) {
    EXPECT_TRUE(together.alone(l).same_bits(alone[static_cast<std::size_t>(l)])) << l;
  }
}

TEST_F(DrydenTest, HasTheStandardsScalesAndIntensitiesAtEveryHeight) {
  for (const bool is_own_height : {true, false}) {
    for (const double height : {0.5, 5.0, 6.096, 60.0, 304.8, 457.2, 609.6, 900.0}) {
      Parameters given{{"airspeed", 20.0}, {"period", 50}};
      if (!is_own_height) given.insert({"height", height});
      const Instance dryden("dryden", world, with(given));
      Group zero = environments(dryden);
      for (int l = 0; l < kLanes; ++l) zero.at(zero.bodies, 2, l) = is_own_height ? height : 70.0;
      dryden.call(Call::kReset, zero, kAll);  // depends on the height
      Group one = zero;
      for (int k = 3; k < 8; ++k) one.at(one.buffer, k) += 1.0;
      apply(dryden, zero);  // the same noise in both
      apply(dryden, one);
      const Expected want = expected_at(height);
      const double t = 0.05;
      const auto left = [&](int word) {
        return one.at(one.buffer, word) - zero.at(zero.buffer, word);
      };
      // Rounding of sums of the order of 1.
      EXPECT_NEAR(left(3), std::exp(-20.0 * t / want.length), 1e-14) << height;
      EXPECT_NEAR(left(4), std::exp(-20.0 * t / want.length), 1e-14) << height;
      EXPECT_NEAR(left(6), std::exp(-20.0 * t / want.length_vertical), 1e-14) << height;
      const double root3 = std::sqrt(3.0);
      const auto filter = [&](int word) {
        return root3 * one.at(one.buffer, word) + (1.0 - root3) * one.at(one.buffer, word + 1);
      };
      EXPECT_NEAR(one.at(one.buffer, 0), want.sigma * one.at(one.buffer, 3), 1e-13) << height;
      EXPECT_NEAR(one.at(one.buffer, 1), want.sigma * filter(4), 1e-13) << height;
      EXPECT_NEAR(one.at(one.buffer, 2), want.sigma_vertical * filter(6), 1e-13) << height;
    }
  }
}

TEST_F(DrydenTest, HasTheVarianceOfTheStandardFromTheFirstSampleOn) {
  const Instance dryden("dryden", world, with({{"height", 50.0}}));
  const Expected want = expected_at(50.0);
  const double sigma[] = {want.sigma, want.sigma, want.sigma_vertical};
  const std::vector<double> same = products(dryden, {0, 1, 2}, {0, 1, 2}, 0);
  const std::vector<double> cross = products(dryden, {0, 1, 2}, {1, 2, 0}, 0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(same[axis] / square(sigma[axis]), 1.0, tolerance(1.0));
    EXPECT_NEAR(cross[axis] / (sigma[axis] * sigma[(axis + 1) % 3]), 0.0, tolerance(0.0));
  }
  Group g = environments(dryden);  // and after ten seconds
  double squares[3] = {};
  for (int e = 0; e < 200; ++e) {
    begin_episode(dryden, g);
    for (int k = 0; k < 1000; ++k) apply(dryden, g);
    for (int axis = 0; axis < 3; ++axis) {
      for (int l = 0; l < kLanes; ++l) squares[axis] += square(g.at(g.buffer, axis, l));
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double variance = squares[axis] / (200 * kLanes);
    EXPECT_NEAR(variance / square(sigma[axis]), 1.0, 4.0 * std::sqrt(2.0 / (200 * kLanes)));
  }
}

TEST_F(DrydenTest, HasTheAutocovarianceOfTheContinuousProcessAtAnyPeriod) {
  const double height = 6.0, airspeed = 8.0;
  const Expected want = expected_at(height);
  for (const int period : {20, 100, 400}) {  // 400 physics steps: at least half a length of w
    const Instance dryden("dryden", world,
                          with({{"height", height}, {"airspeed", airspeed}, {"period", period}}));
    for (const double time : {0.4, 0.8, 2.0}) {
      const int lag = static_cast<int>(std::lround(time / (0.001 * period)));
      const double tau = airspeed * time / want.length,
                   tau_vertical = airspeed * time / want.length_vertical;
      const double rho[] = {std::exp(-tau), (1.0 - tau / 2.0) * std::exp(-tau),
                            (1.0 - tau_vertical / 2.0) * std::exp(-tau_vertical)};
      const double variance[] = {square(want.sigma), square(want.sigma),
                                 square(want.sigma_vertical)};
      const std::vector<double> found = products(dryden, {0, 1, 2}, {0, 1, 2}, lag);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(found[axis] / variance[axis], rho[axis], tolerance(rho[axis]))
            << "axis " << axis << ", " << time << " s, period " << period;
      }
    }
  }
}

TEST_F(DrydenTest, AddsNoiseOfTheExactCovarianceHoweverShortTheStep) {
  // Starting with filters at 0, the result of a call is the noise alone. Its covariance is the
  // integral of (1, s; s, s^2) e^(-2s) over s from 0 to tau, here by Simpson's rule.
  for (const double tau : {1e-6, 1e-3, 0.1, 0.2, 1.0, 10.0}) {
    const double airspeed = 1.0, height = 304.8;  // all lengths are 304.8 m
    world.dt = tau * 304.8 / airspeed;
    const Instance dryden("dryden", world,
                          with({{"height", height}, {"airspeed", airspeed}, {"period", 1}}));
    double integral[3] = {};
    const int parts = 2000;
    for (int i = 0; i <= parts; ++i) {
      const double s = tau * i / parts, weight = i == 0 || i == parts ? 1.0 : 2.0 + 2.0 * (i % 2);
      for (int k = 0; k < 3; ++k) {
        integral[k] += weight * tau / (3.0 * parts) * std::pow(s, k) * std::exp(-2.0 * s);
      }
    }
    double sums[4] = {};
    Group g = environments(dryden);
    const int rounds = 1000;
    for (int round = 0; round < rounds; ++round) {
      begin_episode(dryden, g);
      for (int l = 0; l < kLanes; ++l) {
        for (int k = 3; k < 8; ++k) g.at(g.buffer, k, l) = 0.0;
      }
      apply(dryden, g);
      for (int l = 0; l < kLanes; ++l) {
        const double u = g.at(g.buffer, 3, l), x1 = g.at(g.buffer, 4, l), x2 = g.at(g.buffer, 5, l);
        sums[0] += u * u, sums[1] += x1 * x1, sums[2] += x1 * x2, sums[3] += x2 * x2;
      }
    }
    const double n = rounds * kLanes;
    // The correlation of x1 and x2 is at most sqrt(3)/2; products are within sqrt(2/n) of the
    // geometric mean of the variances.
    const double four = 4.0 * std::sqrt(2.0 / n);
    EXPECT_NEAR(sums[0] / n / (2.0 * integral[0]), 1.0, four) << tau;
    EXPECT_NEAR(sums[1] / n / integral[0], 1.0, four) << tau;
    EXPECT_NEAR((sums[2] / n - integral[1]) / std::sqrt(integral[0] * integral[2]), 0.0, four)
        << tau;
    EXPECT_NEAR(sums[3] / n / integral[2], 1.0, four) << tau;
  }
}

TEST_F(DrydenTest, BlowsAlongAndAcrossTheHeading) {
  const Instance east("dryden", world, with({}));
  const Instance turned("dryden", world, with({{"heading", 0.7}}));
  Group a = environments(east), b = environments(turned);
  begin_episode(east, a);
  begin_episode(turned, b);
  apply(east, a);
  apply(turned, b);
  const double u = a.at(a.buffer, 0), v = a.at(a.buffer, 1), w = a.at(a.buffer, 2);
  // An ulp or two between our cosine and libm's.
  EXPECT_NEAR(b.at(b.buffer, 0), std::cos(0.7) * u - std::sin(0.7) * v, 1e-14);
  EXPECT_NEAR(b.at(b.buffer, 1), std::sin(0.7) * u + std::cos(0.7) * v, 1e-14);
  EXPECT_EQ(b.at(b.buffer, 2), w);
}

TEST_F(DrydenTest, FollowsTheSpeedOfTheBaseWhereThatIsTheLarger) {
  const Instance dryden("dryden", world,
                        with({{"height", 304.8}, {"airspeed", 5.0}, {"follows", true}}));
  for (const double speed : {3.0, 13.0}) {
    Group zero = environments(dryden);
    zero.at(zero.bodies, 7) = 5.0 / 13.0 * speed;
    zero.at(zero.bodies, 9) = -12.0 / 13.0 * speed;
    dryden.call(Call::kReset, zero, kAll);
    Group one = zero;
    one.at(one.buffer, 3) += 1.0;
    apply(dryden, zero);
    apply(dryden, one);
    EXPECT_NEAR(one.at(one.buffer, 3) - zero.at(zero.buffer, 3),
                std::exp(-std::max(speed, 5.0) * 0.01 / 304.8), 1e-14);
  }
}

TEST_F(DrydenTest, GivesEveryRobotTurbulenceOfItsOwnAndItsBodiesTheSame) {
  world.add_payload("bob");
  world.add_quad("other");
  const Instance dryden("dryden", world, with({{"height", 304.8}}));
  // Each sigma is 1 m/s.
  for (const double mean : products(dryden, {0, 1, 2}, {3, 4, 5}, 0)) {
    EXPECT_NEAR(mean, 0.0, tolerance(0.0));
  }
  Group g = environments(dryden);
  begin_episode(dryden, g);
  apply(dryden, g);
  const std::vector<double>& wind = g.held[SKYBODY_HELD_WIND];
  for (int k = 0; k < 3 * kLanes; ++k) {
    const auto i = static_cast<std::size_t>(k), row = static_cast<std::size_t>(3 * kLanes);
    EXPECT_EQ(wind[i], g.buffer[i]);
    EXPECT_EQ(wind[row + i], g.buffer[i]);            // the bob
    EXPECT_EQ(wind[2 * row + i], g.buffer[row + i]);  // the other robot
  }
}

TEST_F(DrydenTest, BlowsAtTheRobotsThatItNamesAndReportsThem) {
  world.add_quad("other");
  const Instance dryden("dryden", world, with({{"robots", std::vector<std::string>{"other"}}}));
  ASSERT_EQ(dryden.declared.reports.size(), 1u);
  EXPECT_EQ(dryden.declared.reports[0].info.name, "velocity");
  EXPECT_EQ(dryden.declared.reports[0].info.count, 3);
  Group g = environments(dryden);
  begin_episode(dryden, g);
  apply(dryden, g);
  EXPECT_EQ(g.at(g.held[SKYBODY_HELD_WIND], 0), 0.0);
  EXPECT_NE(g.at(g.held[SKYBODY_HELD_WIND], 3), 0.0);
  EXPECT_THAT(refusal("dryden", world, {{"robots", std::vector<std::string>{"quda"}}}),
              HasSubstr("no robot `quda`: there are quad, other"));
}

}  // namespace
}  // namespace skybody::testing
