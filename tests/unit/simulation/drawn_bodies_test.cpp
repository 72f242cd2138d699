// A reset draws again when drawn mass properties are those of no rigid body.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/simulation/simulation.h"

namespace skybody {
namespace {

const std::string kInertia = "robots.quad.links.base_link.inertia";

Simulation drawn_hover() {
  return Simulation(
      {.scenario = "hover",
       .overrides = {"randomization=[{plugin: draw, parameters: {what: ['" + kInertia + "[0]', '" +
                     kInertia + "[1]', '" + kInertia + "[2]'], range: [0.9, 1.1], form: scale}}]"},
       .seed = 5});
}

std::vector<double> axes_of(const Simulation& simulation) {
  std::vector<double> axes;
  for (int k = 0; k < 3; ++k) {
    axes.push_back(simulation.param(kInertia + "[" + std::to_string(k) + "]"));
  }
  return axes;
}

/// QDrone2's moments, 0.0144, 0.0166 and 0.0288 kg m^2, each drawn independently by 10 %: 17 % of
/// the draws are those of no rigid body.
TEST(DrawnBodies, AreDrawnAgainUntilARigidBodyHasThem) {
  Simulation simulation = drawn_hover();
  const std::vector<double> nominal = axes_of(simulation);
  const std::vector<float> action(4, 0.0f);
  double largest = 0.0;
  for (int k = 0; k < 1000; ++k) {
    simulation.reset();
    simulation.step(action);
    ASSERT_FALSE(simulation.fault()) << k;
    const std::vector<double> axes = axes_of(simulation);
    EXPECT_GE(axes[0] + axes[1], axes[2]);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_LE(std::abs(axes[i] / nominal[i] - 1.0), 0.1 + 1e-12) << "and nothing drifts";
      largest = std::max(largest, std::abs(axes[i] / nominal[i] - 1.0));
    }
  }
  EXPECT_GT(largest, 0.099) << "the whole range comes";
}

/// A moment of ten times its size exceeds the sum of the others in every draw.
TEST(DrawnBodies, ThatCanNeverBeAreAFaultWhoseReasonNamesThem) {
  Simulation simulation({.scenario = "hover",
                         .overrides = {"randomization=[{plugin: draw, parameters: {what: ['" +
                                       kInertia + "[2]'], range: [9, 10], form: scale}}]"}});
  simulation.reset();
  const std::vector<float> action(4, 0.0f);
  simulation.step(action);
  ASSERT_TRUE(simulation.fault());
  EXPECT_EQ(simulation.compiled().fault_reason(simulation.status()),
            "no rigid body has the mass, centre and inertia of `robots.quad.links.base_link`: a "
            "mass is above 0, and no principal moment above the sum of the other two; narrow what "
            "randomizers draw or callers set: its `.mass`, `.com[0]` and `.inertia[0]` to `[5]` "
            "are what state() reads until the next reset, and what a flight log has under "
            "`params`");
  EXPECT_GT(simulation.state(kInertia + "[2]")[0], 0.2) << "state() reads what was drawn";
}

}  // namespace
}  // namespace skybody
