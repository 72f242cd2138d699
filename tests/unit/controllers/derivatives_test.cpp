// Derivatives of the shipped controllers with respect to all their inputs.
#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Inputs = std::set<std::string>;

class ControllerDerivatives : public ::testing::Test {
 protected:
  ControllerDerivatives() { world.add_quad("quad"); }
  void expect(const std::string& plugin, const Parameters& given, const Inputs& inputs,
              Call call = Call::kControl) {
    PluginWorld own = world;
    expect_derivatives({plugin, own, given, call, {}}, inputs);
  }
  PluginWorld world;
};

TEST_F(ControllerDerivatives, OfRotorCommandsGoStraightThrough) {
  expect("rotor_speed", {}, {"input"});
  expect("throttle", {}, {"input", "params"});
  expect("srt", {}, {"input"});
}

TEST_F(ControllerDerivatives, OfThrustAndTorqueGoThroughAllocationAndLag) {
  for (const char* form : {"priority", "pseudo_inverse", "qp"}) {
    expect("ctbt", {{"allocation", form}}, {"input", "state"});
  }
  expect("ctbt", {{"apply", "body"}}, {"input", "params", "state"});
  expect("ctbt", {{"apply", "body"}}, {"params", "rotor_speed"}, Call::kReset);
}

TEST_F(ControllerDerivatives, OfRatesGoThroughGainsAndFilteredDifferences) {
  expect("ctbr", {}, {"bodies", "input", "params", "state"});
  expect("ctbr", {{"apply", "body"}}, {"bodies", "input", "params", "state"});
  expect("ctbr", {{"apply", "body"}, {"pd", false}}, {"bodies", "input", "params", "state"});
  expect("ctbr", {}, {"bodies", "params", "rotor_speed", "state"}, Call::kReset);
}

TEST_F(ControllerDerivatives, OfAttitudeAndPositionGoThroughTheBodysMotion) {
  expect("attitude", {}, {"bodies", "input", "params"});
  expect("attitude", {{"feed_forward", true}, {"error", "tilt_priority"}},
         {"bodies", "input", "params"});
  expect("position", {}, {"bodies", "input", "params"});
  expect("position", {{"signal", "trajectory"}, {"ki", std::vector<double>{1, 1, 1}}},
         {"bodies", "input", "params", "buffer"});
}

TEST_F(ControllerDerivatives, OfLawsGoThroughMotionGainsAndReference) {
  expect("geometric", {}, {"bodies", "input", "params"});
  expect("geometric", {{"output", "ctbr"}, {"error", "tilt_priority"}},
         {"bodies", "input", "params"});
  const std::vector<double> gains = {2, 2, 3};
  expect("flatness", {{"kp", gains}}, {"bodies", "input", "params"});
  expect("force", {}, {"bodies", "input"});
  expect("sliding_mode", {}, {"bodies", "input", "params"});
  expect("lqr", {}, {"bodies", "input"});
  expect("acceleration", {}, {"input"});
  expect("velocity_tracking", {{"ki", gains}}, {"bodies", "buffer", "input", "params", "state"});
}

TEST_F(ControllerDerivatives, OfIncrementsGoThroughFiltersAndRotors) {
  const Inputs all = {"bodies", "buffer", "input", "params", "rotor_speed", "state"};
  expect("indi", {}, all);
  expect("indi", {{"signal", "attitude"}}, all);
  expect("indi", {{"signal", "ctbr"}}, all);
  expect("indi", {}, {"bodies", "buffer", "rotor_speed", "state"}, Call::kReset);
}

TEST_F(ControllerDerivatives, OfBodyCommandsGoStraightThrough) {
  expect("wrench", {}, {"input"});
  expect("velocity", {}, {"input"});
  expect("velocity", {{"form", "position"}}, {"input"});
}

TEST_F(ControllerDerivatives, OfJointCommandsGoStraightThrough) {
  world.add_body(0, "arm", 0, 2, 0.1, {1e-4, 1e-4, 1e-4});
  world.bodies.back().joint_name = "shoulder";
  expect("joint", {{"joints", std::vector<std::string>{"shoulder"}}, {"effort_limit", 2.0}},
         {"input"});
}

}  // namespace
}  // namespace skybody::testing
