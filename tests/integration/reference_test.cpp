// skybody run --reference and skybody plan: their flights, files and messages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "tests/integration/process.h"

namespace skybody::test {
namespace {

namespace fs = std::filesystem;
using testing::ContainsRegex;
using testing::HasSubstr;

Outcome fly(const fs::path& out, const std::string& reference, std::vector<std::string> more = {}) {
  std::vector<std::string> arguments = {"run",  "hover", "--reference", reference,     "--steps",
                                        "9000", "--out", out.string(),  "--no-picture"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_skybody(arguments);
}

/// A number of the first row of the table of references. Column 0 is the RMS distance [cm], column
/// 5 the RMS error of the yaw [degrees].
double number_of(const std::string& output, int column) {
  std::istringstream lines(output);
  std::string line;
  while (std::getline(lines, line) && line.find("reference of") == line.npos) continue;
  std::getline(lines, line);
  std::getline(lines, line);
  std::istringstream row(line);
  std::string episode, body;
  double number = -1.0;
  row >> episode >> body;
  for (int k = 0; k <= column; ++k) row >> number;
  return number;
}

double rms_of(const std::string& output) { return number_of(output, 0); }

std::string gates(const fs::path& folder) {
  const fs::path file = folder / "gates.yaml";
  std::ofstream(file) << "start: [0, 0, 1.5]\n"
                         "gates:\n"
                         "  - {position: [3, 1, 1.5], direction: [1, 0, 0], reach: 0.3}\n"
                         "  - {position: [6, -1, 2], direction: [1, 0, 0], reach: 0.3}\n"
                         "finish: [8, 2, 1.5]\n";
  return file.string();
}

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Reference, IsFlownByTheChainThatTheScenarioHas) {
  // Within 2 cm by the law that uses the reference's derivatives. With a position setpoint only,
  // the vehicle lags by kd / kp = 0.8 s, 0.8 m at 1 m/s; the last chain requests that.
  const std::vector<std::pair<std::string, double>> chains = {
      {"[{plugin: rotor_speed}]", 2.0},
      {"[{plugin: ctbt}]", 2.0},
      {"[{plugin: ctbr}]", 5.0},
      {"[{plugin: attitude, parameters: {feed_forward: true}}, {plugin: ctbr}]", 5.0},
      {"[{plugin: attitude}, {plugin: ctbr}]", 5.0},
      {"[{plugin: position}, {plugin: attitude}, {plugin: ctbr}]", 5.0},
      {"[{plugin: position, parameters: {signal: position}}, {plugin: attitude}, {plugin: ctbr}]",
       85.0}};
  for (const auto& [chain, most] : chains) {
    const TemporaryFolder folder;
    const Outcome outcome =
        fly(folder.path(), "circle:peak_speed=1,approach=2,ramp=2",
            {"--set", "robots.quad.controllers=" + chain, "--set", "randomization=[]"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_GT(rms_of(outcome.out), 0.0) << chain << outcome.out;
    EXPECT_LT(rms_of(outcome.out), most) << chain << outcome.out;
  }
}

TEST(Reference, TakesThePlaceOfATasksOwnTrajectory) {
  const TemporaryFolder folder;
  const Outcome outcome = run_skybody(
      {"run", "trajectory", "--reference", "lissajous", "--set",
       "robots.quad.controllers=[{plugin: position}, {plugin: attitude}, {plugin: ctbr}]", "--out",
       folder.path().string(), "--no-picture"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_GT(rms_of(outcome.out), 0.0) << outcome.out;
  EXPECT_LT(rms_of(outcome.out), 5.0) << outcome.out;
}

TEST(Reference, FliesTheSameTwiceFromADrawnStart) {
  const TemporaryFolder folder;
  const Outcome one = fly(folder.path(), "lissajous"), two = fly(folder.path(), "lissajous");
  EXPECT_EQ(one.exit_code, 0) << one.err;
  EXPECT_EQ(one.out, two.out);
}

TEST(Reference, SaysWhatItCannotFly) {
  const TemporaryFolder folder;
  const Outcome fast = fly(folder.path(), "circle:peak_speed=20");
  EXPECT_EQ(fast.exit_code, 2);
  EXPECT_THAT(fast.err, ContainsRegex("the fastest `time_scale` that breaks no limit is 0\\.2"));
  const Outcome low =
      fly(folder.path(), "circle", {"--set", "robots.quad.controllers=[{plugin: throttle}]"});
  EXPECT_EQ(low.exit_code, 2);
  EXPECT_THAT(low.err, HasSubstr("takes throttle, to which no controller leads from a reference"));
}

TEST(Reference, IsFlownAtTheFastestScaleThatARefusalTells) {
  const TemporaryFolder folder;
  for (const std::string speed : {"20", "7.3", "9.1", "13.7"}) {
    const std::string path = "circle:peak_speed=" + speed;
    const Outcome fast = run_skybody({"check", "hover", "--reference", path});
    ASSERT_EQ(fast.exit_code, 2) << speed;
    const std::string before = "that breaks no limit is ";
    const std::size_t place = fast.err.find(before);
    ASSERT_NE(place, fast.err.npos) << fast.err;
    const std::size_t first = place + before.size();
    const std::string scale = fast.err.substr(first, fast.err.find(':', first) - first);
    const Outcome slower =
        run_skybody({"check", "hover", "--reference", path + ",time_scale=" + scale});
    EXPECT_EQ(slower.exit_code, 0) << scale << slower.err;
  }
}

TEST(Reference, AsksNmpcsNodesOfThePreview) {
  // A node_step that differs from the reference's default spacing: with points 0.05 s apart, the
  // vehicle would fly 24 cm ahead.
  const TemporaryFolder folder;
  const Outcome outcome =
      fly(folder.path(), "circle:peak_speed=1,approach=2,ramp=2",
          {"--set",
           "robots.quad.controllers=[{plugin: nmpc, parameters: {preview: true, horizon: 15, "
           "node_step: 0.03}}, {plugin: srt}]",
           "--set", "randomization=[]"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_LT(rms_of(outcome.out), 1.0) << outcome.out;
}

TEST(Reference, HoldsTheHeadingThatControllersHold) {
  // With banks to all sides at 4 m/s, a yaw about fixed axes would be wrong by degrees.
  const TemporaryFolder folder;
  const Outcome outcome =
      fly(folder.path(), "circle:peak_speed=4,approach=2,ramp=2",
          {"--set", "robots.quad.controllers=[{plugin: ctbt}]", "--set", "randomization=[]"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_GE(number_of(outcome.out, 5), 0.0) << outcome.out;
  EXPECT_LT(number_of(outcome.out, 5), 0.5) << outcome.out;
}

TEST(Reference, FitsWeakGravity) {
  const Outcome outcome =
      run_skybody({"check", "hover", "--reference", "hold", "--set",
                   "robots.quad.controllers=[{plugin: attitude, parameters: {feed_forward: true}}, "
                   "{plugin: ctbr}]",
                   "--set", "gravity=[0, 0, -3.71]"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST(Reference, FitsTheShippedScenariosWhoseChainsItCanLeadTo) {
  // All scenarios except those whose actions command no chain, and `omav`, which takes poses.
  for (const char* scenario :
       {"arm", "boom", "forest", "gates", "hard_landing", "hover", "hover_crazyflie",
        "hover_firefly", "hover_hummingbird", "hover_learn", "low_battery", "payload",
        "payload_paper", "platform_landing", "rotor_out", "windy_hover"}) {
    const Outcome outcome = run_skybody({"check", scenario, "--reference", "hold"});
    EXPECT_EQ(outcome.exit_code, 0) << scenario << outcome.err;
  }
}

TEST(Reference, FollowsThePapersFigureByTheShippedChain) {
  const TemporaryFolder folder;
  const Outcome outcome = fly(
      folder.path(), "lissajous",
      {"--set", "robots.quad.controllers=[{plugin: position}, {plugin: attitude}, {plugin: ctbr}]",
       "--set", "randomization=[]"});
  EXPECT_LT(rms_of(outcome.out), 3.0) << outcome.out;  // 69.5 cm with a position setpoint only
}

TEST(Reference, TellsWhereALawsOwnLimitsCutIt) {
  // 10 m/s on 12 m by 6 m needs up to 30 m/s^2 sideways; `position` gives 4 by default.
  const std::string chain =
      "robots.quad.controllers=[{plugin: position}, {plugin: attitude}, {plugin: ctbr}]";
  const TemporaryFolder folder;
  const Outcome flown = fly(folder.path(), "figure_eight_fast:approach=2,ramp=2",
                            {"--set", chain, "--set", "randomization=[]"});
  EXPECT_THAT(flown.out, ContainsRegex("[1-9][0-9.]* \\(position\\)"));
  const Outcome checked =
      run_skybody({"check", "hover", "--reference", "figure_eight_fast", "--set", chain});
  EXPECT_EQ(checked.exit_code, 0) << checked.err;
  EXPECT_THAT(checked.err,
              HasSubstr("does not follow its reference as it is: limits of `position`"));
}

TEST(Reference, AsksWhichOfSeveralRobotsFliesIt) {
  const Outcome asked = run_skybody({"check", "formation", "--reference", "circle"});
  EXPECT_EQ(asked.exit_code, 2);
  EXPECT_THAT(asked.err, HasSubstr("several robots could fly the reference"));
  EXPECT_THAT(asked.err, HasSubstr("robot="));
}

TEST(Plan, FindsAQuickerLineThatIsFlownWithinTenCentimetres) {
  const TemporaryFolder folder;
  const fs::path table = folder.path() / "race.csv";
  const Outcome planned = run_skybody({"plan", gates(folder.path()), "qdrone2", "--samples", "3000",
                                       "--reserve", "0.3", "--out", table.string()});
  ASSERT_EQ(planned.exit_code, 0) << planned.err;
  std::istringstream lines(planned.out);
  std::string line;
  for (int k = 0; k < 3; ++k) std::getline(lines, line);
  double count = 0.0, first = 0.0, best = 0.0;
  std::istringstream(line) >> count >> first >> best;
  EXPECT_EQ(count, 3000);
  EXPECT_LT(best, 0.95 * first);
  // A point mass of the same thrust needs at least 2 sqrt(d / a) for the straight way of 8.2 m: a =
  // sqrt(0.7 (39.41 N / 1.54 kg)^2 - g^2) = 15 m/s^2.
  EXPECT_GT(best, 1.48);
  EXPECT_LT(best, 4.0);
  const Outcome flown =
      fly(folder.path() / "flight", "csv:file=" + table.string() + ",approach=2",
          {"--set", "randomization=[]", "--set", "robots.quad.pose.position=[0, 0, 1.5]"});
  EXPECT_EQ(flown.exit_code, 0) << flown.err;
  EXPECT_LT(rms_of(flown.out), 10.0) << flown.out;
}

TEST(Plan, GivesTheSameTableForTheSameSeedAlone) {
  const TemporaryFolder folder;
  const auto table = [&](const std::string& seed) {
    const fs::path file = folder.path() / "line.csv";
    const Outcome outcome = run_skybody({"plan", gates(folder.path()), "qdrone2", "--samples",
                                         "300", "--seed", seed, "--out", file.string()});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return text_of(file);
  };
  EXPECT_EQ(table("5"), table("5"));
  EXPECT_NE(table("5"), table("6"));
}

}  // namespace
}  // namespace skybody::test
