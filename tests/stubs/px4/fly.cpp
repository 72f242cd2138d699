// Runs the module for a few periods with messages of standard input, and prints its setpoints.
//
// Input, a line for each period: armed and in Offboard (1 or 0), age of the messages [us], goal
// (3) and its yaw, position (3), velocity (3), quaternion w x y z, rates (3), heading; in NED and
// FRD. Output: thrust_body[2], roll, pitch, yaw; `none`: no rates, then whether the mode was
// announced.
#include <iostream>

#include "SkybodyPolicy.hpp"

hrt_abstime stub_now = 1000000;

extern "C" int skybody_policy_main(int argc, char *argv[]);

int main(int argc, char *argv[]) {
  if (skybody_policy_main(argc, argv) != 0) return 1;
  SkybodyPolicy *const module = SkybodyPolicy::get_instance();
  std::cout << "period " << module->stub_period << "\n";
  std::cout.precision(9);
  int flies = 0;
  std::uint64_t age = 0;
  while (std::cin >> flies >> age) {
    stub_now += module->stub_period;
    auto &position = stub_vehicle_local_position.message;
    auto &goal = stub_trajectory_setpoint.message;
    auto &attitude = stub_vehicle_attitude.message;
    auto &rates = stub_vehicle_angular_velocity.message;
    std::cin >> goal.position[0] >> goal.position[1] >> goal.position[2] >> goal.yaw;
    std::cin >> position.x >> position.y >> position.z >> position.vx >> position.vy >> position.vz;
    for (float &value : attitude.q) std::cin >> value;
    for (float &value : rates.xyz) std::cin >> value;
    std::cin >> position.heading;
    position.xy_valid = position.z_valid = true;
    position.timestamp = attitude.timestamp = rates.timestamp = goal.timestamp = stub_now - age;
    auto &status = stub_vehicle_status.message;
    status.arming_state = flies ? vehicle_status_s::ARMING_STATE_ARMED : 1;
    status.nav_state = flies ? vehicle_status_s::NAVIGATION_STATE_OFFBOARD : 2;
    const int rates_before = stub_vehicle_rates_setpoint.published;
    const int modes_before = stub_offboard_control_mode.published;
    module->stub_run();
    const vehicle_rates_setpoint_s &given = stub_vehicle_rates_setpoint.message;
    if (stub_vehicle_rates_setpoint.published > rates_before) {
      std::cout << given.thrust_body[2] << " " << given.roll << " " << given.pitch << " "
                << given.yaw;
    } else {
      std::cout << "none";
    }
    std::cout << " " << stub_offboard_control_mode.published - modes_before << "\n";
  }
  delete module;
  return 0;
}
