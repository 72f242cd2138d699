// Stiff scenarios. With joints, fixed steps of a millisecond fail and error-controlled integrators
// succeed; in contact, any step size works, because the step is divided.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/policy/hold/hold_policy.h"
#include "core/simulation/simulation.h"

namespace skybody {
namespace {

Simulation make(const std::string& scenario, const std::vector<std::string>& overrides = {}) {
  return Simulation({.scenario = scenario, .overrides = overrides, .seed = 3});
}

/// Flies the hold policy's actions for `seconds`, or until the episode ends.
void fly(Simulation& simulation, double seconds) {
  HoldPolicy hold(simulation.compiled());
  std::vector<float> action(static_cast<std::size_t>(simulation.action_size()));
  simulation.reset();
  while (simulation.time() < seconds && !simulation.done()) {
    hold.act(simulation, action);
    simulation.step(action);
  }
}

/// Ends with a fault, or because the vehicle has failed its task.
TEST(Boom, FixedStepsOfAMillisecondLoseItWithinASecond) {
  for (const std::string integrator : {"semi_implicit_euler", "midpoint", "rk4"}) {
    for (const std::string dynamics : {"tree", "simbody"}) {
      Simulation simulation =
          make("boom", {"stepping.integrator=" + integrator, "stepping.dynamics=" + dynamics,
                        "stepping.solver=null"});
      fly(simulation, 1.0);
      EXPECT_TRUE(simulation.done()) << integrator << " on " << dynamics;
    }
  }
}

TEST(Boom, HoldsItsPlaceWithCvode) {
  Simulation simulation = make("boom");
  fly(simulation, 5.0);
  ASSERT_FALSE(simulation.done());
  const BodyState& base = simulation.bodies().front();
  EXPECT_LT(std::hypot(base.position.x, base.position.y), 0.1);
  // The position controller has no integral term and does not compensate the boom's weight.
  EXPECT_NEAR(base.position.z, 2.0, 0.2);
  const BodyState& tip = simulation.bodies().back();
  EXPECT_NEAR(base.position.z - tip.position.z, 0.53, 0.01) << "the boom hangs straight";
}

TEST(Boom, StiffMethodsAgree) {
  Simulation bdf = make("boom"),
             dirk = make("boom", {"stepping.integrator=arkode", "stepping.solver.method=dirk"});
  fly(bdf, 0.3);
  fly(dirk, 0.3);
  ASSERT_FALSE(bdf.done() || dirk.done());
  for (std::size_t i = 0; i < bdf.bodies().size(); ++i) {
    EXPECT_LT(norm(bdf.bodies()[i].position - dirk.bodies()[i].position), 1e-4) << i;
  }
}

TEST(HardLanding, ComesToRestOnItsFeet) {
  Simulation simulation = make("hard_landing");
  simulation.reset();
  const std::vector<float> off(4, -1.0f);
  while (simulation.time() < 3.0 && !simulation.done()) simulation.step(off);
  ASSERT_FALSE(simulation.fault());
  const BodyState& base = simulation.bodies().front();
  EXPECT_NEAR(base.position.z, 0.06 - 0.000215, 1e-4) << "feet at -0.06 m, in by the penetration";
  EXPECT_LT(norm(base.velocity), 1e-3);
}

}  // namespace
}  // namespace skybody
