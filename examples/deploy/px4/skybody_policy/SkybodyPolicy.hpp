// Module of PX4: a policy of Skybody flies to the trajectory setpoint by collective thrust and body
// rates, which PX4's rate controller follows. docs/export_policy.md: how the policy is made and
// what is copied where.
//
// It flies while the vehicle is armed and in Offboard, for which it publishes offboard_control_mode
// itself. Axes: PX4's world is north-east-down and its body forward-right-down; Skybody's are
// north-west-up and forward-left-up. So y and z change their signs, also those of quaternions.
#pragma once

#include <drivers/drv_hrt.h>
#include <px4_platform_common/module.h>
#include <uORB/topics/offboard_control_mode.h>
#include <uORB/topics/trajectory_setpoint.h>
#include <uORB/topics/vehicle_angular_velocity.h>
#include <uORB/topics/vehicle_attitude.h>
#include <uORB/topics/vehicle_local_position.h>
#include <uORB/topics/vehicle_rates_setpoint.h>
#include <uORB/topics/vehicle_status.h>

#include <px4_platform_common/px4_work_queue/ScheduledWorkItem.hpp>
#include <uORB/Publication.hpp>
#include <uORB/Subscription.hpp>

#include "policy.h"

class SkybodyPolicy : public ModuleBase<SkybodyPolicy>, public px4::ScheduledWorkItem {
 public:
  SkybodyPolicy();
  ~SkybodyPolicy() override;

  static int task_spawn(int argc, char *argv[]);
  static int custom_command(int argc, char *argv[]);
  static int print_usage(const char *reason = nullptr);
  int print_status() override;

 private:
  void Run() override;
  /// Reads the newest messages. Returns whether there are all of them, and none is old.
  bool Read();
  void Observe(policy_input &input) const;
  void Command(const policy_output &output);
  /// Tells the commander that body rates are commanded; without it Offboard ends.
  void Announce();

  uORB::Subscription _angular_velocity_sub{ORB_ID(vehicle_angular_velocity)};
  uORB::Subscription _attitude_sub{ORB_ID(vehicle_attitude)};
  uORB::Subscription _position_sub{ORB_ID(vehicle_local_position)};
  uORB::Subscription _setpoint_sub{ORB_ID(trajectory_setpoint)};
  uORB::Subscription _status_sub{ORB_ID(vehicle_status)};
  uORB::Publication<offboard_control_mode_s> _mode_pub{ORB_ID(offboard_control_mode)};
  uORB::Publication<vehicle_rates_setpoint_s> _rates_pub{ORB_ID(vehicle_rates_setpoint)};

  vehicle_angular_velocity_s _angular_velocity{};
  vehicle_attitude_s _attitude{};
  vehicle_local_position_s _position{};
  trajectory_setpoint_s _setpoint{};
  vehicle_status_s _status{};
  policy_state _state{};
  bool _flies = false;
  unsigned _refused = 0;  ///< steps without command: old messages, or inputs that are no numbers
};
