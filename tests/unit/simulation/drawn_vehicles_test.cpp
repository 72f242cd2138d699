// Every vehicle that randomizer `vehicle` draws can hover: the baseline flies each of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "core/assemble/compile_scenario.h"
#include "core/policy/hold/hold_policy.h"

namespace skybody {
namespace {

std::shared_ptr<const CompiledScenario> load_vehicles(const std::string& preset) {
  return compile_scenario({.scenario = "vehicles",
                           .overrides = {"randomization[0].parameters.fleet=0",
                                         "randomization[0].parameters.preset=" + preset,
                                         "randomization[1].parameters.position_min=[-0.1,-0.1,2.9]",
                                         "randomization[1].parameters.position_max=[0.1,0.1,3.1]",
                                         "randomization[1].parameters.tilt_max=0.01",
                                         "randomization[1].parameters.yaw_min=-0.05",
                                         "randomization[1].parameters.yaw_max=0.05",
                                         "stepping.dt=0.002", "stepping.action_repeat=5"},
                           .plugin_path = {}});
}

/// One episode of some seconds by the baseline. It hovers if it stays within 0.8 m of the target,
/// and at the end moves at less than 0.2 m/s and turns at less than 0.1 rad/s.
///
/// The slowest vehicles have attitude loops of 0.8 rad/s and position loops of 0.2 rad/s. An
/// initial tilt of 0.01 rad takes them 0.3 m aside before they return, from up to 0.17 m, within
/// half a minute. (A larger rotation lifts vehicles whose rotors speed up much faster than they
/// slow down, for as long.)
bool hovers(Simulation& simulation, HoldPolicy& hold) {
  constexpr int kSteps = 600;  // 6 s
  std::vector<float> action(static_cast<std::size_t>(simulation.action_size()));
  simulation.reset();
  for (int i = 0; i < kSteps; ++i) {
    hold.act(simulation, action);
    simulation.step(action);
    const Vec3<double> error = simulation.base("").position - Vec3<double>{0.0, 0.0, 3.0};
    if (simulation.done() || !(norm(error) < 0.8)) return false;
  }
  const BodyState& base = simulation.base("");
  return norm(base.velocity) < 0.2 && norm(base.angular_velocity) < 0.1;
}

class DrawnVehicles : public testing::TestWithParam<const char*> {};

TEST_P(DrawnVehicles, AllHover) {
  const std::string preset = GetParam();
  const auto compiled = load_vehicles(preset);
  HoldPolicy hold(*compiled);
  double lightest = 1e9, heaviest = 0.0;
  for (std::uint64_t env = 0; env < 100; ++env) {
    Simulation simulation(compiled, 7, env);
    simulation.keep_hash(false);
    for (int n = 0; n < 100; ++n) {
      ASSERT_TRUE(hovers(simulation, hold))
          << preset << ", environment " << env << ", reset " << n << ", mass "
          << simulation.param("robots.quad.links.base_link.mass") << " kg, tau "
          << simulation.rotor_parameter("", 0, "tau_up") << " and "
          << simulation.rotor_parameter("", 0, "tau_down") << " s, at "
          << simulation.base("").position.z << " m, " << norm(simulation.base("").velocity)
          << " m/s, " << norm(simulation.base("").angular_velocity) << " rad/s";
      const double mass = simulation.param("robots.quad.links.base_link.mass");
      lightest = std::min(lightest, mass);
      heaviest = std::max(heaviest, mass);
    }
  }
  EXPECT_GT(heaviest / lightest, 200.0);
}

INSTANTIATE_TEST_SUITE_P(Presets, DrawnVehicles, testing::Values("scaling", "l2f", "raptor"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace skybody
