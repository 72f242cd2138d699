// Plain data: sizes of joints, sums, names.
#include "core/model/robot_model.h"

#include <gtest/gtest.h>

#include "core/model/state_layout.h"

namespace skybody::test {
namespace {

TEST(JointType, QuaternionsCountFourPositionsAndThreeVelocities) {
  EXPECT_EQ(position_size(JointType::kFree), 7);
  EXPECT_EQ(velocity_size(JointType::kFree), 6);
  EXPECT_EQ(position_size(JointType::kBall), 4);
  EXPECT_EQ(velocity_size(JointType::kBall), 3);
}

TEST(JointType, OthersHaveAsManyPositionsAsVelocities) {
  for (const JointType type :
       {JointType::kWeld, JointType::kPin, JointType::kSlider, JointType::kUniversal}) {
    EXPECT_EQ(position_size(type), velocity_size(type));
  }
  EXPECT_EQ(position_size(JointType::kWeld), 0);
  EXPECT_EQ(position_size(JointType::kUniversal), 2);
}

TEST(RobotModel, SumsMassesAndFindsLinksByName) {
  RobotModel model;
  model.bodies.resize(2);
  model.bodies[0].mass.mass = 1.25;
  model.bodies[1].mass.mass = 0.5;
  model.links.resize(3);
  model.links[0].name = "base";
  model.links[2].name = "bob";
  EXPECT_EQ(model.total_mass(), 1.75);
  EXPECT_EQ(model.find_link("bob"), 2);
  EXPECT_EQ(model.find_link("rod"), -1);
}

TEST(StateLayout, FindsParametersByTheirPath) {
  StateLayout layout;
  layout.param_info = {{"robots.quad.links.base.mass", "kg", 1.5, 0.0, 2.0},
                       {"controllers.rate_pd.kp", "", 3.0, 0.0, 9.0}};
  EXPECT_EQ(layout.find_param("controllers.rate_pd.kp"), 1);
  EXPECT_EQ(layout.find_param("controllers.rate_pd.kd"), -1);
}

}  // namespace
}  // namespace skybody::test
