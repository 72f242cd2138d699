// Wind from a table: linear between rows, held or repeated at its ends; refused files.
#include <cmath>
#include <filesystem>
#include <fstream>

#include "tests/unit/dual_harness.h"
#include "tests/unit/io/temp_folder.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;

class WindTableTest : public ::testing::Test {
 protected:
  WindTableTest() { world.add_quad("quad"); }

  std::string write(const std::string& text) const {
    const std::string file = folder.path("wind.csv");
    std::ofstream(file) << text;
    return file;
  }
  Parameters table(const std::string& text, Parameters more = {}) const {
    more.insert({"file", write(text).c_str()});
    return more;
  }
  static std::vector<double> at(const Instance& wind, Group& g, std::uint64_t physics_step) {
    g.physics_step[0] = physics_step;
    std::vector<double>& held = g.held[SKYBODY_HELD_WIND];
    std::fill(held.begin(), held.end(), 0.0);
    wind.call(Call::kApply, g);
    return held;
  }
  std::string refusal_of(const std::string& text) {
    return refusal("wind_table", world, table(text));
  }

  PluginWorld world;
  TempFolder folder;
};

// Rows of 0.1 s, and the same function with one row removed and one inserted.
constexpr const char* kEqual = "t,x,y,z\n0.1,0,1,0\n0.2,1,1,0\n0.3,2,1,0\n0.4,3,1,-2\n0.5,3,1,-4\n";
constexpr const char* kUnequal =
    "# comment\n\nt, x, y, z\r\n0.1,0,1,0\r\n0.3, "
    "2,1,0\r\n0.32,2.2,1,-0.4\r\n0.4,3,1,-2\n0.5,3,1,-4";

TEST_F(WindTableTest, GivesTheBitsOfDouble) {
  for (const bool loop : {false, true}) {
    expect_same_bits("wind_table", world, table(kEqual, {{"loop", loop}, {"start", 0.48}}));
    expect_same_bits("wind_table", world, table(kUnequal, {{"loop", loop}, {"start", 0.48}}));
  }
}

TEST_F(WindTableTest, IsLinearBetweenRowsAndHeldBeyondThem) {
  for (const char* const text : {kEqual, kUnequal}) {
    const Instance wind("wind_table", world, table(text));
    Group g = wind.group(1);
    for (const std::uint64_t step : {0u, 99u, 100u, 137u, 200u, 250u, 310u, 320u, 399u, 400u, 460u,
                                     499u, 500u, 501u, 100000u}) {
      const double t = std::clamp(0.001 * static_cast<double>(step), 0.1, 0.5);
      const std::vector<double> v = at(wind, g, step);
      // Rounding of times of the order of 1, times slopes of at most 20 m/s^2.
      EXPECT_NEAR(v[0], t < 0.4 ? 10.0 * (t - 0.1) : 3.0, 1e-14) << step;
      EXPECT_NEAR(v[1], 1.0, 1e-14) << step;
      EXPECT_NEAR(v[2], t < 0.3 ? 0.0 : -20.0 * (t - 0.3), 1e-14) << step;
    }
  }
}

TEST_F(WindTableTest, BeginsAnewWhereItLoops) {
  for (const char* const text : {kEqual, kUnequal}) {
    const Instance once("wind_table", world, table(text));
    const Instance loop("wind_table", world, table(text, {{"loop", true}}));
    Group g = once.group(1);
    for (const std::uint64_t step : {101u, 177u, 315u, 433u, 499u}) {
      const std::vector<double> v = at(once, g, step);
      for (const std::uint64_t rounds : {0u, 1u, 7u, 1000u}) {
        const std::vector<double> again = at(loop, g, step + 400 * rounds);
        // A time of 400 s and 1000 lengths of the table have roundings of 6e-14 s; slopes are at
        // most 20 m/s^2.
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(again[k], v[k], 1e-11);
      }
    }
    EXPECT_NEAR(at(loop, g, 50)[0], 3.0, 1e-12);  // as 0.45 s
  }
}

TEST_F(WindTableTest, StartsWhereTheScenarioSays) {
  const Instance wind("wind_table", world, table(kEqual));
  const Instance late("wind_table", world, table(kEqual, {{"start", 0.25}}));
  Group a = wind.group(1), b = late.group(1);
  EXPECT_NEAR(at(late, b, 10)[0], at(wind, a, 260)[0], 1e-14);
}

TEST_F(WindTableTest, AStartThatIsNoNumberReadsNoOtherMemory) {
  for (const char* const text : {kEqual, kUnequal}) {
    for (const double start : {std::nan(""), kInfinity, -kInfinity, 1e300, -1e300}) {
      const Instance wind("wind_table", world, table(text, {{"loop", true}}));
      Group g = wind.group(1);
      g.params[static_cast<std::size_t>(wind.env_param("start"))] = start;
      const std::vector<double> v = at(wind, g, 1);
      for (const double x : v) EXPECT_TRUE(std::isnan(x) || std::abs(x) <= 4.0) << start;
    }
  }
}

TEST_F(WindTableTest, HasTheSlopeOfTheTableAsItsDerivative) {
  for (const char* const text : {kEqual, kUnequal}) {
    const Parameters given = table(text, {{"loop", true}, {"start", 0.25}});
    expect_derivatives({"wind_table", world, given, Call::kApply, {}}, {"params"});
  }
}

TEST_F(WindTableTest, BlowsAtTheRobotsThatItNames) {
  world.add_quad("other");
  const Instance wind("wind_table", world,
                      table(kEqual, {{"robots", std::vector<std::string>{"other"}}}));
  Group g = wind.group(1);
  EXPECT_EQ(at(wind, g, 0), (std::vector<double>{0, 0, 0, 0, 1, 0}));
}

TEST_F(WindTableTest, AByteOrderMarkDoesNotCount) {
  const Instance wind("wind_table", world, table("\xef\xbb\xbft,x,y,z\n0,1,2,3\n1,1,2,3\n"));
  Group g = wind.group(1);
  EXPECT_EQ(at(wind, g, 500), (std::vector<double>{1, 2, 3}));
}

TEST_F(WindTableTest, SaysWhereAFileIsWrong) {
  EXPECT_THAT(refusal_of("t,x,y,z\n0,1,2,3\n0.1,1,,3\n"),
              HasSubstr("wind.csv:3: `y` is missing; every row needs t, x, y, z"));
  EXPECT_THAT(refusal_of("t,x,y,z\n0,1,2\n"),
              HasSubstr("wind.csv:2: the line has 3 cells; needed: the 4 of t, x, y, z"));
  EXPECT_THAT(refusal_of("t,x,y,z\n0,1,2,3\n# then\n0,1,2,3\n"),
              HasSubstr("wind.csv:4: the time 0 s does not come after 0 s of the row before; times "
                        "must rise"));
  EXPECT_THAT(refusal_of("t,x,y,z\n0,1,2,nan\n"), HasSubstr("wind.csv:2: `z` is no finite number"));
  EXPECT_THAT(refusal_of("t,x,y,z\ninf,1,2,3\n"), HasSubstr(":2: `t` is no finite number"));
  EXPECT_THAT(refusal_of("t,x,y,z\n0,1,2 m,3\n"), HasSubstr(":2: `y` is no finite number"));
  EXPECT_THAT(refusal_of("t,x,y,z\n0,1,2,101\n"),
              HasSubstr(":2: `z` is 101 m/s; allowed: -100 to 100 m/s"));
  EXPECT_THAT(refusal_of("0,1,2,3\n1,1,2,3\n"),
              HasSubstr("wind.csv:1: the first line must be t,x,y,z"));
  EXPECT_THAT(refusal_of("t,x,y,z\n0,1,2,3\n"),
              HasSubstr("wind.csv: the file has 1 row of numbers; needed: two or more below"));
  EXPECT_THAT(refusal_of(""), HasSubstr("the file has 0 rows of numbers"));
}

TEST_F(WindTableTest, SaysThatAFileIsMissingOrTooLarge) {
  const std::string folder_itself = folder.path("");
  EXPECT_THAT(refusal("wind_table", world, {{"file", folder_itself.c_str()}}),
              HasSubstr("there is no such file; give a CSV file with the columns t, x, y, z"));
  const std::string file = write("t,x,y,z\n0,1,2,3\n1,1,2,3\n");
  std::filesystem::resize_file(file, (16u << 20) + 1);
  EXPECT_THAT(refusal("wind_table", world, {{"file", file.c_str()}}),
              HasSubstr("the file is larger than 16 MiB, which is the most that is allowed"));
}

}  // namespace
}  // namespace skybody::testing
