// Aerodynamic coefficients at hubs: the rotors that receive them, and refused parameters.
#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using Words = std::vector<std::string>;

const Parameters kAll{{"axial_drag", 1e-4}, {"flapping", 2e-5}, {"translational_lift", 3e-3}};

class BladeFlappingTest : public ::testing::Test {
 protected:
  BladeFlappingTest() {
    world.add_quad("quad");
    world.add_quad("other");
  }
  PluginWorld world;
};

TEST_F(BladeFlappingTest, GivesTheBitsOfDouble) { expect_same_bits("blade_flapping", world, kAll); }

TEST_F(BladeFlappingTest, GivesEachRotorItsCoefficients) {
  const Instance flapping("blade_flapping", world, kAll);
  Group g = flapping.group(1);
  flapping.call(Call::kApply, g);
  Numbers expected;
  for (int rotor = 0; rotor < 8; ++rotor) expected.insert(expected.end(), {1e-4, 2e-5, 3e-3});
  EXPECT_EQ(g.held[SKYBODY_HELD_ROTOR_FLOW], expected);
}

TEST_F(BladeFlappingTest, ServesTheRobotsThatItNames) {
  const Instance flapping("blade_flapping", world,
                          {{"axial_drag", 1e-4}, {"robots", Words{"other"}}});
  Group g = flapping.group(1);
  flapping.call(Call::kApply, g);
  EXPECT_EQ(g.held[SKYBODY_HELD_ROTOR_FLOW][3 * 3], 0.0);
  EXPECT_EQ(g.held[SKYBODY_HELD_ROTOR_FLOW][3 * 4], 1e-4);
}

TEST_F(BladeFlappingTest, EachEnvironmentHasCoefficientsOfItsOwn) {
  const Instance flapping("blade_flapping", world, kAll);
  Group g = flapping.group(2);
  g.at(g.params, flapping.env_param("flapping"), 1) = 7e-5;
  flapping.call(Call::kApply, g, 3u);
  EXPECT_EQ(g.at(g.held[SKYBODY_HELD_ROTOR_FLOW], SKYBODY_FLOW_FLAPPING, 0), 2e-5);
  EXPECT_EQ(g.at(g.held[SKYBODY_HELD_ROTOR_FLOW], SKYBODY_FLOW_FLAPPING, 1), 7e-5);
}

TEST_F(BladeFlappingTest, HasTheDerivativesOfDifferences) {
  expect_derivatives({"blade_flapping", world, kAll, Call::kApply, {}}, {"params"});
}

TEST_F(BladeFlappingTest, SaysWhatDoesNotFit) {
  EXPECT_EQ(refusal("blade_flapping", world, {{"robots", Words{"quda"}}}),
            "no robot `quda`: there are quad, other");
  EXPECT_EQ(refusal("blade_flapping", world, {{"robots", Words{"quad", "quad"}}}),
            "`robots` names `quad` twice: name each robot once");
  world.add_robot("crate", 0, 0, 0);
  EXPECT_EQ(refusal("blade_flapping", world, {{"robots", Words{"crate"}}}),
            "robot `crate` has no rotors, which the effect blade_flapping acts on: leave it out of "
            "`robots`, or give it a rotors file");
  PluginWorld bare;
  bare.add_robot("crate", 0, 0, 0);
  EXPECT_EQ(refusal("blade_flapping", bare, {}),
            "no robot has rotors, which the effect blade_flapping acts on: give one a rotors file, "
            "or leave the effect out");
}

}  // namespace
}  // namespace skybody::testing
