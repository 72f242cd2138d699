// skybody run: table, log and picture; no file is lost or incomplete.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "core/io/files/shipped_files.h"
#include "tests/integration/flight_file.h"
#include "tests/integration/process.h"

namespace skybody::test {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::ContainsRegex;
using testing::ElementsAre;
using testing::HasSubstr;

const char* const kHover = "hover";

std::string python() {
  const char* chosen = std::getenv("SKYBODY_PYTHON");
  if (chosen != nullptr) return chosen;
  const std::string own = SKYBODY_SOURCE_DIR "/.venv/bin/python3";
  return fs::exists(own) ? own : "python3";
}

bool python_can_draw() {
  try {
    return run_program(python(), {"-c", "import h5py, matplotlib, skybody"}).exit_code == 0;
  } catch (const std::runtime_error&) {
    return false;
  }
}

std::string read_text(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Arguments of a short flight of hover without a picture.
std::vector<std::string> short_flight(const fs::path& out, std::vector<std::string> more = {}) {
  std::vector<std::string> arguments = {"run",   kHover,       "--steps",     "100",
                                        "--out", out.string(), "--no-picture"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(Run, EndsWithATableAndTheLog) {
  const TemporaryFolder folder;
  const Outcome outcome = run_skybody(short_flight(folder.path()));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_THAT(outcome.out, ContainsRegex("episode +steps +time"));
  EXPECT_THAT(outcome.out, ContainsRegex("\n1 +100 +0\\.[0-9]+ .*stopped +quad\\."));
  EXPECT_THAT(outcome.out, ContainsRegex("\nall +100 "));
  EXPECT_THAT(outcome.out, HasSubstr("log      " + (folder.path() / "flight.h5").string() + "\n"));
  EXPECT_THAT(folder.names(), ElementsAre("flight.h5"));
}

TEST(Run, LogsEveryStepAndWhereItCameFrom) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_skybody(short_flight(folder.path(), {"--seed", "7"})).exit_code, 0);
  const FlightFile log(folder.path() / "flight.h5");
  EXPECT_THAT(log.shape("/episodes/0001/bodies"), ElementsAre(101, 1, 13));
  EXPECT_THAT(log.shape("/episodes/0001/rotor_speed"), ElementsAre(101, 4));
  EXPECT_THAT(log.shape("/episodes/0001/goal"), ElementsAre(101, 1, 4));
  const std::vector<double> time = log.values("/episodes/0001/time");
  EXPECT_EQ(time.front(), 0.0);
  EXPECT_NEAR(time.back(), 100 * log.number_attribute("/", "dt"), 1e-12);
  EXPECT_THAT(log.events("/episodes/0001"), ElementsAre("reset", "stopped"));
  EXPECT_EQ(log.text_attribute("/", "seed"), "7");
  EXPECT_EQ(log.text_attribute("/", "policy"), "hold");
  EXPECT_THAT(log.text_attribute("/", "scenario_text"), HasSubstr("robots:"));
  EXPECT_EQ(log.text_attribute("/", "scenario_hash").size(), 16u);
  EXPECT_FALSE(log.text_attribute("/versions", "simbody").empty());
  EXPECT_EQ(log.texts("/params/paths").size(), log.values("/episodes/0001/params").size());
}

TEST(Run, TellsWhatEffectsReportAndWhatIsDrawnInFlight) {
  const TemporaryFolder folder;
  const std::vector<std::string> more = {
      "--set", "effects=[{plugin: battery, name: pack, parameters: {cells: 4, capacity: 1.5}}]",
      "--set",
      "randomization=[{plugin: draw, name: late, parameters: {what: "
      "[robots.quad.links.base_link.mass], range: [0.9, 1.1], form: scale, when: time, "
      "time: [0.01, 0.02]}}]"};
  const Outcome outcome = run_skybody(short_flight(folder.path(), more));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("reported value +unit +least +greatest +at the end"));
  EXPECT_THAT(outcome.out, ContainsRegex("pack\\.charge +0\\.9[0-9]* +0\\.9[0-9]* +0\\.9"));
  EXPECT_THAT(outcome.out, HasSubstr("robots.quad.links.base_link.mass"));
  const FlightFile log(folder.path() / "flight.h5");
  const std::vector<std::string> names = log.texts_attribute("/episodes/0001/info", "columns");
  const auto charge = std::find(names.begin(), names.end(), "pack.charge") - names.begin();
  ASSERT_LT(charge, std::ssize(names));
  const std::vector<double> values = log.values("/episodes/0001/info");
  const std::size_t last = values.size() - names.size() + static_cast<std::size_t>(charge);
  EXPECT_LT(values[last], 1.0);
  EXPECT_GT(values[last], 0.9);
}

/// The table stays as narrow as a terminal: a fault reason of 260 letters made it unreadable.
TEST(Run, ALongReasonOfAFaultStandsBelowTheTable) {
  const TemporaryFolder folder;
  const Outcome outcome = run_skybody(
      short_flight(folder.path(),
                   {"--episodes", "2", "--set",
                    "randomization=[{plugin: draw, parameters: {what: "
                    "['robots.quad.links.base_link.inertia[2]'], range: [9, 10], form: scale}}]"}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("\n1 .* fault: no rigid body has [a-z, ]*\\.\\.\\. "));
  EXPECT_THAT(outcome.out,
              HasSubstr("\nepisodes 1, 2: fault: no rigid body has the mass, centre and inertia of "
                        "`robots.quad.links.base_link`: "));
  std::istringstream table(outcome.out);
  std::string line;
  for (int k = 0; k < 5 && std::getline(table, line); ++k) EXPECT_LE(line.size(), 160u) << line;
}

/// -1 marks an event that did not happen; it must not enter an average of times.
TEST(Run, ATimeThatDidNotComeIsNever) {
  const TemporaryFolder folder;
  const auto failing = [&](const std::string& chance) {
    return run_skybody(
        short_flight(folder.path(),
                     {"--episodes", "2", "--set",
                      "effects=[{plugin: rotor_failure, name: failure, parameters: {kind: partial, "
                      "earliest: 0.05, latest: 0.05, probability: " +
                          chance + "}}]"}));
  };
  const Outcome none = failing("0");
  ASSERT_EQ(none.exit_code, 0) << none.err;
  EXPECT_THAT(none.out, ContainsRegex("failure\\.time +s +never +never +never"));
  EXPECT_THAT(failing("1").out, ContainsRegex("failure\\.time +s +0\\.05 +0\\.05 +0\\.05"));
}

TEST(Run, EveryValueOfATargetHasItsUnit) {
  const TemporaryFolder folder;
  const Outcome outcome = run_skybody(
      short_flight(folder.path(), {"--set", "infos=[task.target]", "--set",
                                   "task.parameters={robot: quad, target: [0, 0, 1, 0]}"}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("task\\.target\\[2\\] +m +1 "));
  EXPECT_THAT(outcome.out, ContainsRegex("task\\.target\\[3\\] +rad +0 "));
}

/// The largest distance of a flight's only body from its goal, from row `first` on [m].
double worst_distance(const FlightFile& log, std::size_t first) {
  const std::vector<double> bodies = log.values("/episodes/0001/bodies");
  const std::vector<double> goals = log.values("/episodes/0001/goal");
  double worst = bodies.size() / 13 > first ? 0.0 : HUGE_VAL;
  for (std::size_t row = first; row < bodies.size() / 13; ++row) {
    const double *place = bodies.data() + 13 * row, *goal = goals.data() + 4 * row;
    worst =
        std::fmax(worst, std::hypot(place[0] - goal[0], place[1] - goal[1], place[2] - goal[2]));
  }
  return worst;
}

TEST(Run, HoldHoversWithinAMillimetre) {
  const TemporaryFolder folder;
  const Outcome outcome = run_skybody(
      {"run", kHover, "--steps", "8000", "--out", folder.path().string(), "--no-picture"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_LT(worst_distance(FlightFile(folder.path() / "flight.h5"), 8000), 1e-3);
}

TEST(Run, HoldFollowsTheTrajectoryOfATaskByTheLawsThatTakeOne) {
  // Velocity and acceleration are known, jerk is not. Attitudes lag by some 10 ms, which the
  // position loops reduce to centimetres; `nmpc` assumes the present acceleration for a whole
  // second. With a position setpoint only, the vehicle is 0.8 m behind.
  const std::vector<std::pair<std::string, double>> chains = {
      {"{plugin: position}, {plugin: attitude}, {plugin: ctbr}", 0.05},
      {"{plugin: geometric}, {plugin: ctbt}", 0.05},
      {"{plugin: nmpc}, {plugin: srt}", 0.1},
      {"{plugin: nmpc, parameters: {preview: true}}, {plugin: srt}", 0.1}};
  for (const auto& [chain, most] : chains) {
    const TemporaryFolder folder;
    const Outcome outcome = run_skybody({"run", "trajectory", "--steps", "1500", "--set",
                                         "robots.quad.controllers=[" + chain + "]", "--out",
                                         folder.path().string(), "--no-picture"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_LT(worst_distance(FlightFile(folder.path() / "flight.h5"), 500), most) << chain;
  }
}

TEST(Run, FliesEveryShippedScenario) {
  for (const std::string& name : shipped_scenarios()) {
    const TemporaryFolder folder;
    const Outcome outcome = run_skybody(
        {"run", name, "--steps", "30", "--out", folder.path().string(), "--no-picture"});
    EXPECT_EQ(outcome.exit_code, 0) << name << outcome.err;
    // An episode may end sooner: the pursuers of `chase` need about as long.
    EXPECT_THAT(outcome.out, ContainsRegex("\nall +[1-3][0-9] ")) << name;
  }
}

TEST(Run, FliesTheSameFlightTwice) {
  const TemporaryFolder first, second;
  const std::vector<std::string> random = {"--policy", "random", "--episodes", "2", "--seed", "3"};
  ASSERT_EQ(run_skybody(short_flight(first.path(), random)).exit_code, 0);
  ASSERT_EQ(run_skybody(short_flight(second.path(), random)).exit_code, 0);
  const FlightFile a(first.path() / "flight.h5"), b(second.path() / "flight.h5");
  EXPECT_THAT(a.names("/episodes"), ElementsAre("0001", "0002"));
  EXPECT_EQ(a.values("/episodes/0002/bodies"), b.values("/episodes/0002/bodies"));
  EXPECT_NE(a.values("/episodes/0001/action"), a.values("/episodes/0002/action"));
}

TEST(Run, TakesOverrides) {
  const TemporaryFolder folder;
  const Outcome outcome = run_skybody(
      short_flight(folder.path(), {"--set", "stepping.dt=0.002", "--set", "stepping.horizon=40"}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const FlightFile log(folder.path() / "flight.h5");
  EXPECT_EQ(log.number_attribute("/", "dt"), 0.002);
  EXPECT_THAT(log.events("/episodes/0001"), ElementsAre("reset", "truncated"));
  EXPECT_THAT(log.shape("/episodes/0001/time"), ElementsAre(41));
}

TEST(Run, NeverReusesADefaultFolder) {
  const TemporaryFolder folder;
  const std::vector<std::string> arguments = {"run", kHover, "--steps", "3", "--no-picture"};
  ASSERT_EQ(run_skybody(arguments, {.folder = folder.path()}).exit_code, 0);
  ASSERT_EQ(run_skybody(arguments, {.folder = folder.path()}).exit_code, 0);
  EXPECT_TRUE(fs::exists(folder.path() / "flights/hover-0/flight.h5"));
  EXPECT_TRUE(fs::exists(folder.path() / "flights/hover-0-2/flight.h5"));
}

TEST(Run, ReplacesWhatLiesInAnExplicitFolder) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "flight.h5") << "old";
  std::ofstream(folder.path() / "flight-0001.png") << "old";
  std::ofstream(folder.path() / "notes.txt") << "mine";
  ASSERT_EQ(run_skybody(short_flight(folder.path())).exit_code, 0);
  EXPECT_THAT(folder.names(), ElementsAre("flight.h5", "notes.txt"));
  EXPECT_TRUE(FlightFile(folder.path() / "flight.h5").has("/episodes/0001"));
}

TEST(Run, LeavesNothingWhereItCannotWrite) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "file") << "mine";
  const fs::path out = folder.path() / "file";
  const Outcome outcome = run_skybody(short_flight(out));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("error: cannot write into the folder " + out.string()));
  EXPECT_EQ(lines_of(outcome.err).size(), 1u);
  EXPECT_EQ(read_text(out), "mine");
}

TEST(Run, LeavesNothingWhenTheScenarioIsWrong) {
  const TemporaryFolder folder;
  const Outcome outcome =
      run_skybody(short_flight(folder.path() / "out", {"--set", "stepping.dt=soon"}));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(folder.names().empty());
}

TEST(Run, KeepsWhatWasFlownWhenItIsInterrupted) {
  const TemporaryFolder folder;
  const auto has_flown = [&] {  // into the temporary file, which has another name
    const std::vector<std::string> names = folder.names();
    std::error_code ignored;
    return !names.empty() && fs::file_size(folder.path() / names[0], ignored) > 100000 && !ignored;
  };
  const Outcome outcome = run_skybody({"run", kHover, "--steps", "1000000000", "--set",
                                       "stepping.horizon=0", "--out", folder.path().string()},
                                      {.interrupt_when = has_flown});
  EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("interrupted"));
  EXPECT_THAT(lines_of(outcome.out),
              Contains("draw it  skybody plot " + (folder.path() / "flight.h5").string()));
  EXPECT_THAT(outcome.err, HasSubstr("interrupted in episode 1 of 1"));
  EXPECT_THAT(folder.names(), ElementsAre("flight.h5"));
  const FlightFile log(folder.path() / "flight.h5");
  EXPECT_THAT(log.events("/episodes/0001"), ElementsAre("reset", "interrupted"));
  EXPECT_GT(log.shape("/episodes/0001/time").at(0), 100u);
}

TEST(Run, DrawsAPicture) {
  if (!python_can_draw()) GTEST_SKIP() << "no Python with skybody, matplotlib and h5py";
  const TemporaryFolder folder;
  const Outcome outcome = run_skybody(
      {"run", kHover, "--steps", "50", "--episodes", "2", "--out", folder.path().string()},
      {.environment = {"SKYBODY_PYTHON=" + python()}});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
  EXPECT_THAT(folder.names(), ElementsAre("flight-0001.png", "flight-0002.png", "flight.h5"));
  EXPECT_EQ(read_text(folder.path() / "flight-0001.png").substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_THAT(lines_of(outcome.out),
              Contains("picture  " + (folder.path() / "flight-0002.png").string()));
}

TEST(Run, LogsWhereAnythingTouches) {
  const TemporaryFolder folder;
  const std::string collision = "collision";
  const Outcome outcome = run_skybody(
      {"run", collision, "--steps", "150", "--out", folder.path().string(), "--no-picture"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const FlightFile log(folder.path() / "flight.h5");
  const std::vector<double> touching = log.values("/episodes/0001/touching");
  ASSERT_EQ(touching.size(), 151u);
  EXPECT_EQ(touching.front(), 0.0) << "apart";
  EXPECT_EQ(touching.back(), 0.0) << "apart again";
  const auto rows = std::count(touching.begin(), touching.end(), 1.0);
  EXPECT_GT(rows, 0);
  EXPECT_LT(rows, 60);
}

TEST(Run, SucceedsWithoutAPictureWhereThereIsNoPython) {
  const TemporaryFolder folder;
  const Outcome outcome =
      run_skybody({"run", kHover, "--steps", "5", "--out", folder.path().string()},
                  {.environment = {"SKYBODY_PYTHON=/nowhere/python3"}});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err,
            "warning: no picture: cannot start /nowhere/python3: No such file or directory; name a "
            "Python that has the package skybody, matplotlib and h5py in SKYBODY_PYTHON\n");
  EXPECT_THAT(folder.names(), ElementsAre("flight.h5"));
}

}  // namespace
}  // namespace skybody::test
