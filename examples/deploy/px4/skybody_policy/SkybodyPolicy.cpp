#include "SkybodyPolicy.hpp"

#include <math.h>
#include <px4_platform_common/log.h>

namespace {

constexpr unsigned kPeriod = static_cast<unsigned>(1e6f * POLICY_PERIOD + 0.5f);  // us
constexpr hrt_abstime kOldest = 200000;  // us, of a message that the policy still uses
constexpr float kPi = 3.14159265359f;

float Wrapped(float angle) {
  while (angle > kPi) angle -= 2.0f * kPi;
  while (angle < -kPi) angle += 2.0f * kPi;
  return angle;
}

bool IsRecent(hrt_abstime timestamp, hrt_abstime now) { return timestamp + kOldest > now; }

}  // namespace

SkybodyPolicy::SkybodyPolicy()
    : ScheduledWorkItem(MODULE_NAME, px4::wq_configurations::nav_and_controllers) {}

SkybodyPolicy::~SkybodyPolicy() { ScheduleClear(); }

void SkybodyPolicy::Run() {
  if (should_exit()) {
    ScheduleClear();
    exit_and_cleanup();
    return;
  }
  const bool is_complete = Read();
  const bool flies = _status.arming_state == vehicle_status_s::ARMING_STATE_ARMED &&
                     _status.nav_state == vehicle_status_s::NAVIGATION_STATE_OFFBOARD;
  if (flies && !_flies) policy_reset(&_state);
  _flies = flies;
  if (!is_complete) {
    // Nothing is published: after COM_OF_LOSS_T the commander leaves Offboard for its failsafe.
    _refused += flies ? 1 : 0;
    return;
  }
  if (!flies) {
    Announce();  // so that Offboard can be chosen
    return;
  }
  policy_input input{};
  policy_output output{};
  Observe(input);
  if (policy_step(&_state, &input, &output) == 0) {
    ++_refused;
    return;
  }
  Announce();
  Command(output);
}

bool SkybodyPolicy::Read() {
  _angular_velocity_sub.update(&_angular_velocity);
  _attitude_sub.update(&_attitude);
  _position_sub.update(&_position);
  _setpoint_sub.update(&_setpoint);
  _status_sub.update(&_status);
  const hrt_abstime now = hrt_absolute_time();
  return IsRecent(_angular_velocity.timestamp, now) && IsRecent(_attitude.timestamp, now) &&
         IsRecent(_position.timestamp, now) && _position.xy_valid && _position.z_valid &&
         _setpoint.timestamp != 0;
}

void SkybodyPolicy::Observe(policy_input &input) const {
  const float *const goal = _setpoint.position;
  input.position_error[0] = goal[0] - _position.x;
  input.position_error[1] = -(goal[1] - _position.y);
  input.position_error[2] = -(goal[2] - _position.z);
  input.velocity[0] = _position.vx;
  input.velocity[1] = -_position.vy;
  input.velocity[2] = -_position.vz;
  input.yaw_error = -Wrapped(_setpoint.yaw - _position.heading);
  const float sign = _attitude.q[0] < 0.0f ? -1.0f : 1.0f;  // w >= 0
  input.attitude[0] = sign * _attitude.q[0];
  input.attitude[1] = sign * _attitude.q[1];
  input.attitude[2] = -sign * _attitude.q[2];
  input.attitude[3] = -sign * _attitude.q[3];
  input.angular_velocity[0] = _angular_velocity.xyz[0];
  input.angular_velocity[1] = -_angular_velocity.xyz[1];
  input.angular_velocity[2] = -_angular_velocity.xyz[2];
}

void SkybodyPolicy::Command(const policy_output &output) {
  vehicle_rates_setpoint_s rates{};
  rates.roll = output.rate_x;
  rates.pitch = -output.rate_y;
  rates.yaw = -output.rate_z;
  rates.thrust_body[2] = -output.thrust / POLICY_THRUST_HIGH;  // -1: all motors at full thrust
  rates.timestamp = hrt_absolute_time();
  _rates_pub.publish(rates);
}

void SkybodyPolicy::Announce() {
  offboard_control_mode_s mode{};
  mode.body_rate = true;
  mode.timestamp = hrt_absolute_time();
  _mode_pub.publish(mode);
}

int SkybodyPolicy::task_spawn(int argc, char *argv[]) {
  (void)argc;
  (void)argv;
  auto *const instance = new SkybodyPolicy();
  if (instance == nullptr) {
    PX4_ERR("no memory");
    return PX4_ERROR;
  }
  _object.store(instance);
  _task_id = task_id_is_work_queue;
  instance->ScheduleOnInterval(kPeriod);
  return PX4_OK;
}

int SkybodyPolicy::print_status() {
  PX4_INFO("%s, every %u us, %u steps refused", _flies ? "flies" : "waits for Offboard", kPeriod,
           _refused);
  return 0;
}

int SkybodyPolicy::custom_command(int argc, char *argv[]) {
  (void)argc;
  (void)argv;
  return print_usage("unknown command");
}

int SkybodyPolicy::print_usage(const char *reason) {
  if (reason != nullptr) PX4_WARN("%s", reason);
  PRINT_MODULE_DESCRIPTION("Flies a policy of Skybody to the trajectory setpoint, in Offboard.");
  PRINT_MODULE_USAGE_NAME("skybody_policy", "controller");
  PRINT_MODULE_USAGE_COMMAND("start");
  PRINT_MODULE_USAGE_DEFAULT_COMMANDS();
  return 0;
}

extern "C" __EXPORT int skybody_policy_main(int argc, char *argv[]) {
  return SkybodyPolicy::main(argc, argv);
}
