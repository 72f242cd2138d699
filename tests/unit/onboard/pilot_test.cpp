#include "onboard/pilot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "onboard/safe_command.h"
#include "tests/unit/onboard/hover_mission.h"

namespace skybody::onboard {
namespace {

/// A pilot that flies, level in the middle.
class PilotTest : public testing::Test {
 protected:
  void fly(int signal = SKYBODY_CTBR) {
    mission_ = hover_mission(signal);
    pilot_ = std::make_unique<Pilot>(mission_);
    pilot_->situation().set_body(0, level_at(0, 0, 1.5));
    pilot_->engage();
    pilot_->step({0.0});
  }
  Decision step_at(double time, double age = 0.0, double lateness = 0.0) {
    return pilot_->step({time, age, lateness, 1});
  }
  Mission mission_;
  std::unique_ptr<Pilot> pilot_;
};

TEST_F(PilotTest, WaitsUntilItIsEngaged) {
  mission_ = hover_mission();
  Pilot pilot(mission_);
  EXPECT_EQ(pilot.step({0.0}).mode, Mode::kWaiting);
  EXPECT_TRUE(pilot.step({0.0}).command.empty());
}

TEST_F(PilotTest, CommandsTheScaledActionOfThePolicy) {
  fly();
  const Decision decision = step_at(0.01);
  ASSERT_EQ(decision.mode, Mode::kPolicy);
  EXPECT_FLOAT_EQ(decision.action[0], static_cast<float>(kHoverAction));
  // -0.02 is rounded to float: 6e-9 of 10 N.
  EXPECT_NEAR(decision.command[0], 9.8, 1e-7);
  EXPECT_NEAR(decision.command[1], -0.04, 1e-7);
}

TEST_F(PilotTest, EachLimitLeadsToTheSafeCommandWithItsReason) {
  struct Case {
    Motion motion;
    double age, lateness;
    std::uint32_t reason;
  };
  Motion tilted = level_at(0, 0, 1.5);
  tilted.rotation = {std::cos(0.8), std::sin(0.8), 0.0, 0.0};  // 1.6 rad
  const Case cases[] = {{level_at(0, 0, 1.5), 0.3, 0.0, kStale},
                        {level_at(0, 0, 1.5), 0.0, 0.06, kLate},
                        {tilted, 0.0, 0.0, kTilt},
                        {level_at(9, 0, 1.5), 0.0, 0.0, kFence}};
  for (const Case& c : cases) {
    fly();
    mission_.limits.fence_high[0] = 5.0;
    pilot_->situation().set_body(0, c.motion);
    const Decision decision = step_at(0.01, c.age, c.lateness);
    EXPECT_EQ(decision.mode, Mode::kSafe) << c.reason;
    EXPECT_EQ(decision.reasons, c.reason);
    EXPECT_NEAR(decision.command[0], 0.9 * 9.8 * kMass, 1e-9) << c.reason;
  }
}

TEST_F(PilotTest, StaysSafeUntilItIsEngagedAgainAndStopsAfterTheDescent) {
  fly();
  EXPECT_EQ(step_at(0.01, 1.0).mode, Mode::kSafe);
  EXPECT_EQ(step_at(0.02).mode, Mode::kSafe);
  EXPECT_EQ(step_at(5.1).mode, Mode::kStopped);
  EXPECT_EQ(step_at(5.11).command[0], 0.0);
  pilot_->engage();
  EXPECT_EQ(step_at(5.12).mode, Mode::kPolicy);
}

TEST_F(PilotTest, ACommandThatIsNoNumberIsNeverSent) {
  mission_ = hover_mission();
  mission_.policy.layers[0].bias[2] = std::numeric_limits<double>::quiet_NaN();
  Pilot pilot(mission_);
  pilot.engage();
  const Decision decision = pilot.step({0.0});
  EXPECT_EQ(decision.mode, Mode::kSafe);
  EXPECT_EQ(decision.reasons, kBadCommand);
  for (const double value : decision.command) EXPECT_TRUE(std::isfinite(value));
}

TEST_F(PilotTest, AnInfiniteObservationIsSafe) {
  fly();
  pilot_->situation().params[0] = std::numeric_limits<double>::infinity();  // the target
  EXPECT_EQ(step_at(0.01).reasons, kBadObservation);
}

TEST_F(PilotTest, TheDescentTurnsTheVehicleLevel) {
  fly();
  Motion rolled = level_at(0, 0, 1.5);
  rolled.rotation = {std::cos(0.25), std::sin(0.25), 0.0, 0.0};  // rolled to the right
  pilot_->situation().set_body(0, rolled);
  pilot_->disengage();
  const Decision decision = step_at(0.01);
  EXPECT_LT(decision.command[1], -1.0);  // rolls to the left
  EXPECT_EQ(decision.reasons, kDisengaged);
}

TEST_F(PilotTest, RotorsHaveNoDescentAndStop) {
  EXPECT_FALSE(can_descend(SKYBODY_ROTOR_SPEED));
  fly(SKYBODY_ROTOR_SPEED);
  const Decision decision = step_at(0.01, 1.0);
  EXPECT_EQ(decision.mode, Mode::kStopped);
  for (const double value : decision.command) EXPECT_EQ(value, 0.0);
}

TEST_F(PilotTest, AForceDescentPointsUpwards) {
  fly(SKYBODY_FORCE);
  const Decision decision = step_at(0.01, 1.0);
  EXPECT_EQ(decision.command[0], 0.0);
  EXPECT_NEAR(decision.command[2], 0.9 * 9.8 * kMass, 1e-9);
}

}  // namespace
}  // namespace skybody::onboard
