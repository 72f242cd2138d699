// Randomizer `lissajous`: the paper's family of references.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;
using Numbers = std::vector<double>;

constexpr int kDraws = 4000;
constexpr double kDegree = 3.14159265358979323846 / 180.0;

class LissajousDraws : public ::testing::Test {
 protected:
  LissajousDraws() {
    world.add_quad("quad");
    for (const char* name : {"amplitude[0]", "amplitude[1]", "amplitude[2]", "centre[0]",
                             "centre[1]", "centre[2]", "cycles[0]", "cycles[1]", "cycles[2]",
                             "phase[0]", "phase[1]", "phase[2]", "peak_speed", "along"}) {
      params[name] =
          world.add_param(std::string("robots.quad.controllers.reference.") + name, -7.0);
    }
  }
  /// The values of a parameter over many episodes.
  std::map<std::string, Numbers> draw(const Parameters& given = {}) {
    const Instance lissajous("lissajous", world, given);
    Group g = lissajous.group(1);
    std::map<std::string, Numbers> drawn;
    for (int n = 0; n < kDraws; ++n) {
      ++g.episode[0];
      lissajous.call(Call::kRandomize, g);
      for (const auto& [name, param] : params) drawn[name].push_back(g.at(g.params, param));
    }
    return drawn;
  }
  PluginWorld world;
  std::map<std::string, int> params;
};

/// Uniform: mean and ends, by 5 deviations of the mean and 1 % of the range.
void expect_uniform(const Numbers& values, double low, double high) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  const double width = high - low;
  EXPECT_NEAR(sum / kDraws, 0.5 * (low + high), 5 * width / std::sqrt(12.0 * kDraws));
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  EXPECT_GE(*least, low);
  EXPECT_LE(*most, high);
  EXPECT_LT(*least, low + 0.01 * width);
  EXPECT_GT(*most, high - 0.01 * width);
}

TEST_F(LissajousDraws, HavePapersRanges) {
  auto drawn = draw();
  expect_uniform(drawn["amplitude[0]"], 1.35, 1.75);
  expect_uniform(drawn["amplitude[1]"], 1.35, 1.75);
  expect_uniform(drawn["amplitude[2]"], 0.3, 0.4);
  expect_uniform(drawn["centre[2]"], 0.7, 1.0);
  expect_uniform(drawn["phase[0]"], 70 * kDegree, 110 * kDegree);
  expect_uniform(drawn["peak_speed"], 1.0, 1.5);
  EXPECT_NE(drawn["amplitude[0]"], drawn["amplitude[1]"]);
}

TEST_F(LissajousDraws, PickTheFiveRatiosAlikeAndTheHeadingHalfOfTheTime) {
  auto drawn = draw();
  std::map<int, int> counts;
  for (std::size_t n = 0; n < kDraws; ++n) {
    const double ratio =
        100 * drawn["cycles[0]"][n] + 10 * drawn["cycles[1]"][n] + drawn["cycles[2]"][n];
    ++counts[static_cast<int>(ratio)];
  }
  std::set<int> ratios;
  for (const auto& [ratio, count] : counts) {
    ratios.insert(ratio);
    EXPECT_NEAR(count, kDraws / 5, 5 * std::sqrt(kDraws * 0.2 * 0.8)) << ratio;
  }
  EXPECT_EQ(ratios, (std::set<int>{111, 221, 112, 211, 121}));
  const auto ahead = std::count(drawn["along"].begin(), drawn["along"].end(), 1.0);
  EXPECT_NEAR(ahead, kDraws / 2, 5 * std::sqrt(kDraws * 0.25));
  EXPECT_EQ(std::count(drawn["along"].begin(), drawn["along"].end(), 0.0), kDraws - ahead);
}

TEST_F(LissajousDraws, LeaveTheRestAlone) {
  auto drawn = draw();
  for (const char* name : {"centre[0]", "centre[1]", "phase[1]", "phase[2]"}) {
    EXPECT_EQ(std::count(drawn[name].begin(), drawn[name].end(), -7.0), kDraws) << name;
  }
}

TEST_F(LissajousDraws, PutARobotNearTheFiguresBeginningInEveryEpisode) {
  const int start = world.robots[0].first_param + 6;  // after the disturbance
  for (int k = 0; k < 3; ++k) params["start" + std::to_string(k)] = start + k;
  auto drawn = draw({{"robot", "quad"}, {"start_within", Numbers{0.5, 0.2, 0.0}}, {"every", 4}});
  std::array<Numbers, 3> off;
  for (std::size_t n = 0; n < kDraws; ++n) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::string axis = "[" + std::to_string(k) + "]";
      const double beginning = drawn["centre" + axis][n] +
                               drawn["amplitude" + axis][n] * std::sin(drawn["phase" + axis][n]);
      off[k].push_back(drawn["start" + std::to_string(k)][n] - beginning);
    }
    if (n % 4 != 0) {
      ASSERT_EQ(drawn["phase[0]"][n], drawn["phase[0]"][n - 1]);
      ASSERT_NE(off[0][n], off[0][n - 1]);
    }
  }
  expect_uniform(off[0], -0.5, 0.5);
  expect_uniform(off[1], -0.2, 0.2);
  for (const double z : off[2]) EXPECT_NEAR(z, 0.0, 1e-14);
}

TEST_F(LissajousDraws, DrawTheSameFiguresWithAndWithoutARobot) {
  const Numbers alone = draw()["peak_speed"];
  EXPECT_EQ(draw({{"robot", "quad"}})["peak_speed"], alone);
}

TEST_F(LissajousDraws, GiveTheBitsOfDouble) {
  PluginWorld own = world;
  expect_same_bits("lissajous", own);
  expect_same_bits("lissajous", own, {{"robot", "quad"}});
}

TEST_F(LissajousDraws, BadRangesAndRatiosAreRefused) {
  EXPECT_THAT(refusal("lissajous", world, {{"peak_speed", Numbers{2, 1}}}),
              HasSubstr("`peak_speed` is 2 to 1: swap them"));
  EXPECT_THAT(refusal("lissajous", world, {{"ratios", Numbers{1, 2}}}),
              HasSubstr("`ratios` has 2 values; allowed: three for each ratio"));
  EXPECT_THAT(refusal("lissajous", world, {{"ratios", Numbers{1, 2, 1, 0, 0, 0}}}),
              HasSubstr("`ratios` has 0, 0, 0, by which nothing swings: leave these out"));
  EXPECT_THAT(refusal("lissajous", world, {{"start_within", Numbers{1, 1, 1}}}),
              HasSubstr("`start_within` is given without `robot`"));
  EXPECT_THAT(refusal("lissajous", world, {{"robot", "quda"}}), HasSubstr("quda"));
  world.robots[0].fixed_base = 1;
  EXPECT_THAT(refusal("lissajous", world, {{"robot", "quad"}}), HasSubstr("has a fixed base"));
  PluginWorld bare;
  bare.add_quad("quad");
  EXPECT_NE(refusal("lissajous", bare, {}), "");
}

}  // namespace
}  // namespace skybody::testing
