// skybody modes: levels of control as the plugins declare them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/io/files/text.h"
#include "tests/integration/process.h"

namespace skybody::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

const std::string kChain =
    "robots.quad.controllers=[{plugin: position, name: guide}, {plugin: attitude}, {plugin: ctbr}]";

/// First words of the rows between a heading that begins with `heading` and the next empty line.
std::vector<std::string> rows_below(const std::string& text, const std::string& heading) {
  std::vector<std::string> rows;
  bool is_within = false;
  for (const std::string& line : lines_of(text)) {
    if (line.empty()) is_within = false;
    if (is_within && line.front() != '-') rows.push_back(split_words(line)[0]);
    if (line.rfind(heading, 0) == 0) is_within = true;
  }
  return rows;
}

TEST(Modes, ShowAScenariosChainLevelByLevelWithWhoImplementsIt) {
  const Outcome outcome = run_skybody({"modes", "hover", "--set", kChain});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(rows_below(outcome.out, "level "),
              ElementsAre("position[4]", "attitude[5]", "ctbr[4]"));
  EXPECT_THAT(outcome.out, HasSubstr("robot quad: actions are position[4]"));
  EXPECT_THAT(outcome.out, HasSubstr("guide"));
  EXPECT_THAT(outcome.out, HasSubstr("2 x +-10, +-5"));  // the rates of ctbr
}

TEST(Modes, SayAtWhichLevelsAPolicyMayEnter) {
  const Outcome outcome = run_skybody({"modes", "hover"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::vector<std::string> levels = rows_below(outcome.out, "enters at");
  for (const char* level : {"rotor_speed[4]", "srt[4]", "ctbt[4]", "ctbr[4]", "attitude[5]",
                            "position[4]", "velocity[6]", "wrench[6]"}) {
    EXPECT_NE(std::find(levels.begin(), levels.end(), level), levels.end()) << level;
  }
  EXPECT_THAT(outcome.out, HasSubstr("[{plugin: position}, {plugin: attitude}, {plugin: ctbr}]"));
  EXPECT_THAT(outcome.out, HasSubstr("joint: `joints` names no joint to drive"));
}

TEST(Modes, OfEveryListedChainFly) {
  const Outcome outcome = run_skybody({"modes", "hover"});
  int flown = 0;
  for (const std::string& line : lines_of(outcome.out)) {
    const std::size_t list = line.find("[{plugin:");
    if (list == std::string::npos) continue;
    const std::string chain = "robots.quad.controllers=" + line.substr(list);
    EXPECT_EQ(run_skybody({"check", "hover", "--set", chain}).exit_code, 0) << line;
    ++flown;
  }
  EXPECT_GE(flown, 12);
}

TEST(Modes, OfATaskWithATrajectoryTakeItByDefault) {
  const std::string position = "{plugin: position, parameters: {signal: position}}, ";
  const std::string rest = "{plugin: attitude}, {plugin: ctbr}]";
  const auto modes = [&](const std::string& first) {
    return run_skybody({"modes", "trajectory", "--set", "robots.quad.controllers=[" + first + rest})
        .out;
  };
  const std::string by_default = modes("{plugin: position}, ");
  EXPECT_THAT(by_default, HasSubstr("robot quad: actions are trajectory[17]"));
  EXPECT_THAT(by_default, HasSubstr("[" + position + rest));
  EXPECT_THAT(modes(position), HasSubstr("robot quad: actions are position[4]"));
}

TEST(Modes, OfRobotsThatAreAlikeAreSaidOnce) {
  const Outcome outcome = run_skybody({"modes", "formation_2"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("modes of quad1, quad2, as a list for"));
  EXPECT_THAT(outcome.out, Not(HasSubstr("modes of quad2")));
}

TEST(Modes, OfWhatTakesNoCommandHaveNoActions) {
  const Outcome outcome = run_skybody({"modes", "platform_landing"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("robot pad: takes no actions"));
  EXPECT_THAT(outcome.out, HasSubstr("takes no command"));
  EXPECT_THAT(outcome.out, HasSubstr("modes of pad"));
}

TEST(Modes, WithoutAScenarioListAllLevelsAndControllers) {
  const Outcome outcome = run_skybody({"modes"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::vector<std::string> levels = rows_below(outcome.out, "level ");
  EXPECT_NE(std::find(levels.begin(), levels.end(), "trajectory"), levels.end());
  EXPECT_THAT(outcome.out, HasSubstr("form: position"));  // the second form of `velocity`
  EXPECT_THAT(outcome.out, HasSubstr("ranges of the next controller"));  // `delay`
}

TEST(Modes, AreJsonForPrograms) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"modes", "--json"}, {"modes", "hover", "--json"}}) {
    const Outcome outcome = run_skybody(arguments);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.out.front(), '{');
    EXPECT_THAT(outcome.out, HasSubstr("\"signal\": \"rotor_speed\""));
    EXPECT_THAT(outcome.out, Not(HasSubstr("inf")));  // JSON has no infinity
  }
}

TEST(Modes, OfAScenarioWithMistakesAreItsErrors) {
  const Outcome outcome = run_skybody(
      {"modes", "hover", "--set", "robots.quad.controllers=[{plugin: position}, {plugin: ctbr}]"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("between them belongs `attitude`"));
}

}  // namespace
}  // namespace skybody::test
