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
  for (const char* const profile : {"power", "logarithmic"}) {
    Parameters sheared = gusty;
    sheared.insert({{"profile", profile}, {"roughness", 0.3}});
    expect_derivatives({"wind", world, sheared, Instance::Call::kApply, {}},
                       {"bodies", "params", "state"});
  }
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
