// Chains that lead from one level of control to another.
#include "core/assemble/controller_survey.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/plugin_host/search_path.h"

namespace skybody {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

ControllerMode mode(const std::string& plugin, Level takes, Level gives,
                    std::vector<std::string> options = {}) {
  ControllerMode made;
  made.plugin = plugin;
  made.takes = takes;
  made.gives = gives;
  made.options = std::move(options);
  made.acts = gives.signal == SKYBODY_ROTOR_SPEED;
  return made;
}

constexpr Level kPosition{SKYBODY_POSITION, 4}, kAttitude{SKYBODY_ATTITUDE, 5},
    kAttitudeWithRates{SKYBODY_ATTITUDE, 8}, kCtbr{SKYBODY_CTBR, 4},
    kRotors{SKYBODY_ROTOR_SPEED, 4}, kTrajectory{SKYBODY_TRAJECTORY, 17};

ControllerSurvey small_survey() {
  ControllerSurvey survey;
  survey.modes = {mode("position", kPosition, kAttitude),
                  mode("attitude", kAttitude, kCtbr),
                  mode("attitude", kAttitudeWithRates, kCtbr, {"feed_forward: true"}),
                  mode("ctbr", kCtbr, kRotors),
                  mode("flatness", kTrajectory, kAttitudeWithRates),
                  mode("motors", kRotors, kRotors)};
  return survey;
}

TEST(ShortestChain, LeadsToAnyActuatorOrToOneSignal) {
  const ControllerSurvey survey = small_survey();
  EXPECT_THAT(shortest_chain(survey, {SKYBODY_POSITION}, -1), ElementsAre(0, 1, 3));
  EXPECT_THAT(shortest_chain(survey, {SKYBODY_POSITION}, SKYBODY_CTBR), ElementsAre(0, 1));
  EXPECT_THAT(shortest_chain(survey, {SKYBODY_ROTOR_SPEED}, -1), ElementsAre(5));
}

TEST(ShortestChain, JoinsControllersOfOneSizeOnly) {
  EXPECT_THAT(shortest_chain(small_survey(), {SKYBODY_TRAJECTORY}, -1), ElementsAre(4, 2, 3));
  EXPECT_THAT(shortest_chain(small_survey(), kAttitudeWithRates, -1), ElementsAre(2, 3));
}

TEST(ShortestChain, GoesOnBehindAWrenchThatHasNoSite) {
  ControllerSurvey survey;
  survey.modes = {mode("pose", {SKYBODY_POSE, 7}, {SKYBODY_WRENCH, 6}),
                  mode("tilt", {SKYBODY_WRENCH, 6}, kRotors)};
  EXPECT_THAT(shortest_chain(survey, {SKYBODY_POSE}, -1), ElementsAre(0, 1));
}

TEST(ShortestChain, PrefersDefaultsToOptions) {
  ControllerSurvey survey = small_survey();
  survey.modes.insert(survey.modes.begin(), mode("indi", kAttitude, kRotors, {"signal: attitude"}));
  EXPECT_EQ(chain_text(survey, shortest_chain(survey, {SKYBODY_ATTITUDE}, -1)),
            "`attitude`, then `ctbr`");
}

TEST(ShortestChain, IsEmptyWhereNothingLeadsThere) {
  EXPECT_THAT(shortest_chain(small_survey(), {SKYBODY_CTBR}, SKYBODY_POSITION), IsEmpty());
  EXPECT_THAT(shortest_chain(small_survey(), {SKYBODY_FORCE}, -1), IsEmpty());
  EXPECT_THAT(shortest_chain({}, {SKYBODY_CTBR}, -1), IsEmpty());
}

TEST(ShortestChain, EndsWhereControllersLeadRoundInACircle) {
  ControllerSurvey survey;
  survey.modes = {mode("down", kPosition, kAttitude), mode("up", kAttitude, kPosition)};
  EXPECT_THAT(shortest_chain(survey, {SKYBODY_POSITION}, SKYBODY_CTBR), IsEmpty());
}

TEST(ShortestChain, LeavesOutWhatPassesCommandsOn) {
  ControllerSurvey survey = small_survey();
  survey.modes[1].passes_on = true;
  EXPECT_THAT(shortest_chain(survey, {SKYBODY_ATTITUDE, 5}, -1), IsEmpty());
}

TEST(ChainText, NamesControllersWithWhatDiffersFromTheirDefaults) {
  const ControllerSurvey survey = small_survey();
  EXPECT_EQ(chain_text(survey, {4, 2}), "`flatness`, then `attitude` (`feed_forward: true`)");
  EXPECT_EQ(chain_yaml(survey, {4, 2}),
            "[{plugin: flatness}, {plugin: attitude, parameters: {feed_forward: true}}]");
}

TEST(Survey, OfAVehicleOfItsOwnAsksShippedControllers) {
  const PluginRegistry registry({shipped_plugin_folder()});
  const ControllerSurvey survey =
      survey_controllers(registry.known(SKYBODY_CONTROLLER), survey_vehicle(), 0);
  EXPECT_GE(survey.modes.size(), 12U);
  EXPECT_FALSE(shortest_chain(survey, {SKYBODY_POSITION}, SKYBODY_ROTOR_SPEED).empty());
  for (const ControllerMode& found : survey.modes) {
    EXPECT_EQ(found.low.size(), found.high.size()) << found.plugin;
  }
}

}  // namespace
}  // namespace skybody
