// A fault of the state reports its most likely cause, with the value.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/simulation/simulation.h"

namespace skybody {
namespace {

const std::string kGaveUp = "the physics gave up or left the finite numbers: ";

/// The reason of the fault in the next twenty steps; empty: none.
std::string reason_of(Simulation& simulation) {
  for (int k = 0; k < 20; ++k) {
    simulation.step(std::vector<float>(static_cast<std::size_t>(simulation.action_size()), 0.0f));
    if (simulation.fault()) return simulation.compiled().fault_reason(simulation.status());
  }
  return "";
}

TEST(FaultCause, IsTheLinkThatMovesTooFast) {
  Simulation simulation({.scenario = "hover"});
  simulation.reset();
  BodyState base = simulation.base("quad");
  base.velocity.z = 9.9e5;
  simulation.teleport("quad", base);
  EXPECT_EQ(reason_of(simulation),
            kGaveUp + "link `base_link` of robot `quad` moved at 9.9e+05 m/s before");
}

TEST(FaultCause, IsTheLinkThatTurnsTooFast) {
  Simulation simulation({.scenario = "arm"});
  simulation.reset();
  BodyState base = simulation.base("hexa");
  base.angular_velocity.y = 5e5;
  simulation.teleport("hexa", base);
  EXPECT_EQ(reason_of(simulation).substr(0, kGaveUp.size()), kGaveUp);
  const std::string reason = simulation.compiled().fault_reason(simulation.status());
  EXPECT_NE(reason.find(" of robot `hexa` "), std::string::npos) << reason;
  EXPECT_NE(reason.find(" rad/s before"), std::string::npos) << reason;
}

}  // namespace
}  // namespace skybody
