// Drag coefficients: the bodies that receive them, drawable parameters, refused parameters.
#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using Words = std::vector<std::string>;
using ::testing::HasSubstr;

const Parameters kBoth{{"linear", Numbers{0.1, 0.2, 0.3}},
                       {"quadratic", Numbers{0.01, 0.02, 0.03}}};

class BodyDragTest : public ::testing::Test {
 protected:
  BodyDragTest() {
    world.add_quad("quad");
    world.add_payload("bob");
    world.add_quad("other");
  }
  /// Held values for bodies quad, bob and other, six each.
  Numbers held(Parameters given) {
    given.insert(kBoth.begin(), kBoth.end());
    const Instance drag("body_drag", world, given);
    Group g = drag.group(1);
    drag.call(Call::kApply, g);
    return g.held[SKYBODY_HELD_BODY_DRAG];
  }
  static Numbers on(bool first, bool second, bool third) {
    Numbers all;
    for (const bool is_on : {first, second, third}) {
      for (const double c : {0.1, 0.2, 0.3, 0.01, 0.02, 0.03}) all.push_back(is_on ? c : 0.0);
    }
    return all;
  }
  PluginWorld world;
};

TEST_F(BodyDragTest, GivesTheBitsOfDouble) { expect_same_bits("body_drag", world, kBoth); }

TEST_F(BodyDragTest, HoldsBackTheBasesOfAllRobots) { EXPECT_EQ(held({}), on(true, false, true)); }

TEST_F(BodyDragTest, HoldsBackTheRobotsThatItNamesOnce) {
  EXPECT_EQ(held({{"robots", Words{"other", "other"}}}), on(false, false, true));
}

TEST_F(BodyDragTest, HoldsBackTheBodyOfANamedLink) {
  EXPECT_EQ(held({{"robots", Words{"quad"}}, {"link", "bob"}}), on(false, true, false));
}

TEST_F(BodyDragTest, EachEnvironmentHasCoefficientsOfItsOwn) {
  const Instance drag("body_drag", world, kBoth);
  Group g = drag.group(2);
  g.at(g.params, drag.env_param("quadratic") + 2, 1) = 0.5;
  drag.call(Call::kApply, g, 3u);
  EXPECT_EQ(g.at(g.held[SKYBODY_HELD_BODY_DRAG], 5, 0), 0.03);
  EXPECT_EQ(g.at(g.held[SKYBODY_HELD_BODY_DRAG], 5, 1), 0.5);
}

TEST_F(BodyDragTest, HasTheDerivativesOfDifferences) {
  expect_derivatives({"body_drag", world, kBoth, Call::kApply, {}}, {"params"});
}

TEST_F(BodyDragTest, SaysWhatDoesNotFit) {
  EXPECT_EQ(refusal("body_drag", world, {{"robots", Words{"quda"}}}),
            "no robot `quda`: there are quad, other");
  EXPECT_EQ(refusal("body_drag", world, {{"link", "bob"}}),
            "robot `other` has no link `bob`: there are base");
}

}  // namespace
}  // namespace skybody::testing
