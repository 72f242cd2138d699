// Wind against its equation: steady part, shape and times of gusts, affected bodies.
#include <cmath>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;

class WindTest : public ::testing::Test {
 protected:
  WindTest() { world.add_quad("quad"); }

  static std::vector<double>& wind_of(Group& g) { return g.held[SKYBODY_HELD_WIND]; }
  /// Wind before a physics step, from the engine's neutral values.
  static std::vector<double> at(const Instance& wind, Group& g, std::uint64_t physics_step) {
    g.physics_step[0] = physics_step;
    std::fill(wind_of(g).begin(), wind_of(g).end(), 0.0);
    wind.call(Call::kApply, g);
    return wind_of(g);
  }
  PluginWorld world;
};

TEST_F(WindTest, GivesTheBitsOfDouble) {
  expect_same_bits("wind", world, {{"velocity", std::vector<double>{1.0, 2.0, 3.0}}});
  expect_same_bits("wind", world, {{"gust_speed", 4.0}, {"gust_interval", 0.001}});
  for (const char* const profile : {"power", "logarithmic"}) {
    expect_same_bits("wind", world,
                     {{"velocity", std::vector<double>{1.0, 2.0, 3.0}}, {"profile", profile}});
  }
}

TEST_F(WindTest, IsSteadyWithoutGusts) {
  const Instance wind("wind", world, {{"velocity", std::vector<double>{3.0, -1.0, 0.5}}});
  Group g = wind.group(1);
  wind.call(Call::kReset, g);
  for (const std::uint64_t step : {0u, 1u, 5000u}) {
    EXPECT_EQ(at(wind, g, step), (std::vector<double>{3.0, -1.0, 0.5}));
  }
}

TEST_F(WindTest, AGustHasTheShapeOfOneMinusCosine) {
  const Instance wind("wind", world,
                      {{"gust_speed", 4.0},
                       {"gust_duration", 0.2},
                       {"gust_interval", 0.05},
                       {"gust_direction", std::vector<double>{0.0, 2.0, 0.0}}});
  Group g = wind.group(1);
  wind.call(Call::kReset, g);
  const double begin = std::bit_cast<double>(g.state[0]);
  const auto first = static_cast<std::uint64_t>(begin / 0.001) + 1;
  for (std::uint64_t step = first; step * 0.001 < begin + 0.2; ++step) {
    const double age = static_cast<double>(step) * 0.001 - begin;
    const double speed = 2.0 * (1.0 - std::cos(2.0 * kPi * age / 0.2));
    const std::vector<double> v = at(wind, g, step);
    EXPECT_NEAR(v[1], speed, 1e-12);  // libm's cosine and ours differ by an ulp or two
    EXPECT_EQ(v[0], 0.0);
  }
}

TEST_F(WindTest, GustsComeAtTheMeanInterval) {
  const Instance wind("wind", world,
                      {{"gust_speed", 1.0}, {"gust_duration", 0.01}, {"gust_interval", 0.03}});
  Group g = wind.group(1);
  wind.call(Call::kReset, g);
  double begin = std::bit_cast<double>(g.state[0]);
  int gusts = 0;
  double headings = 0.0;
  for (std::uint64_t step = 0; step < 400000; ++step) {
    at(wind, g, step);
    const double now = std::bit_cast<double>(g.state[0]);
    if (now == begin) continue;
    begin = now;
    ++gusts;
    headings += std::bit_cast<double>(g.state[1]);
  }
  // 400 s in cycles of 0.03 s waiting, 0.01 s gust and on average half a step until its end is
  // noticed: 9876 expected, standard deviation 0.75 sqrt(n) = 75. The tolerance is four of them.
  EXPECT_NEAR(gusts, 9876, 300);
  EXPECT_NEAR(headings / gusts, 0.0, 4.0 * std::sqrt(0.5 / gusts));
}

TEST_F(WindTest, BlowsAtTheRobotsThatItNames) {
  world.add_quad("other");
  const Instance wind("wind", world,
                      {{"velocity", std::vector<double>{1.0, 0.0, 0.0}},
                       {"robots", std::vector<std::string>{"other"}}});
  Group g = wind.group(1);
  wind.call(Call::kReset, g);
  EXPECT_EQ(at(wind, g, 0), (std::vector<double>{0, 0, 0, 1, 0, 0}));
}

TEST_F(WindTest, GrowsWithTheHeightOfEachBodyByItsProfile) {
  world.add_payload("bob");
  const std::vector<double> velocity{8.0, -6.0, 1.0};
  const Instance power("wind", world,
                       {{"velocity", velocity},
                        {"profile", "power"},
                        {"exponent", 0.2},
                        {"reference_height", 6.0},
                        {"least_height", 0.5}});
  const Instance logarithmic("wind", world,
                             {{"velocity", velocity},
                              {"profile", "logarithmic"},
                              {"roughness", 0.6},
                              {"reference_height", 6.0},
                              {"least_height", 0.5}});
  for (const double height : {-1.0, 0.3, 0.55, 2.0, 6.0, 50.0}) {
    Group g = power.group(1);
    g.at(g.bodies, 2) = 6.0;
    g.at(g.bodies, 13 + 2) = height;
    const double floored = std::max(height, 0.5);
    const double share[] = {std::pow(floored / 6.0, 0.2),
                            std::max(0.0, std::log(floored / 0.6) / std::log(6.0 / 0.6))};
    const Instance* const winds[] = {&power, &logarithmic};
    for (std::size_t i = 0; i < 2; ++i) {
      winds[i]->call(Call::kReset, g);
      const std::vector<double> v = at(*winds[i], g, 0);
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(v[k], velocity[k]);  // at the reference
        // A few ulp between our logarithms and exponentials and libm's.
        EXPECT_NEAR(v[3 + k], share[i] * velocity[k], 1e-14 * 8.0) << height;
      }
    }
  }
}

TEST_F(WindTest, GustsGrowWithTheHeightAsTheSteadyWindDoes) {
  const auto gusty = [&](const char* profile) {
    return Parameters{
        {"gust_speed", 4.0}, {"gust_duration", 0.2}, {"gust_interval", 0.05}, {"profile", profile}};
  };
  const Instance uniform("wind", world, gusty("uniform")), power("wind", world, gusty("power"));
  Group a = uniform.group(1), b = power.group(1);
  a.at(a.bodies, 2) = b.at(b.bodies, 2) = 3.0;
  uniform.call(Call::kReset, a);
  power.call(Call::kReset, b);
  const auto peak = static_cast<std::uint64_t>(1000.0 * (std::bit_cast<double>(a.state[0]) + 0.1));
  const double here = at(uniform, a, peak)[0], there = at(power, b, peak)[0];
  EXPECT_GT(std::abs(here), 0.01);
  EXPECT_NEAR(there / here, std::pow(0.3, 1.0 / 7.0), 1e-14);  // a few ulp
}

TEST_F(WindTest, SaysWhatDoesNotFit) {
  const auto refusal = [&](const Parameters& given) {
    try {
      const Instance wind("wind", world, given);
    } catch (const std::runtime_error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_THAT(refusal({{"gust_speed", 1.0}, {"gust_duration", 0.01}, {"period", 10}}),
              HasSubstr("`gust_duration` is 0.01 s, but the effect is called every 0.01 s"));
  EXPECT_THAT(refusal({{"gust_direction", std::vector<double>{0.0, 0.0, 0.0}}}),
              HasSubstr("not all of them 0"));
  EXPECT_THAT(refusal({{"profile", "logarithmic"}, {"reference_height", 1.0}}),
              HasSubstr("`reference_height` is 1 m; with `profile: logarithmic` it must be more "
                        "than 1 m, which is the greatest `roughness`"));
  EXPECT_THAT(refusal({{"robots", std::vector<std::string>{"quda"}}}),
              HasSubstr("no robot `quda`: there are quad"));
}

}  // namespace
}  // namespace skybody::testing
