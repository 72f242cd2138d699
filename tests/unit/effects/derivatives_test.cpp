// Derivatives of the shipped effects in parameters and state.
#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

TEST(EffectDerivatives, OfWindDependOnItsParametersAndTheGustsBegin) {
  PluginWorld world;
  world.add_quad("quad");
  const Parameters gusty{{"velocity", std::vector<double>{1.0, -2.0, 0.5}},
                         {"gust_speed", 4.0},
                         {"gust_duration", 1.5},
                         {"gust_interval", 0.2}};
  expect_derivatives({"wind", world, gusty, Instance::Call::kApply, {}}, {"params", "state"});
}

TEST(EffectDerivatives, OfDrydenDependOnItsParametersItsFiltersAndTheSpeedThatItFollows) {
  PluginWorld world;
  world.add_quad("quad");
  const Parameters fast{{"follows", true}, {"airspeed", 0.5}, {"height", 10.0}, {"period", 100}};
  expect_derivatives({"dryden", world, fast, Instance::Call::kApply, {}},
                     {"bodies", "buffer", "params"});
}

}  // namespace
}  // namespace skybody::testing
