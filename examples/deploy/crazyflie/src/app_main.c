/* App of the Crazyflie's firmware: a policy of Skybody hovers by collective thrust and body rates.
 *
 * The firmware's estimator gives the state, its rate controller follows the rates. The app flies
 * while the parameter `policy.fly` is 1, towards `policy.x`, `y`, `z`, `yaw`; otherwise it sends
 * nothing, and others may command. docs/export_policy.md: how the policy is made and what is copied
 * where.
 *
 * Axes: the firmware's world has z up and its body x forward, y left, z up, as Skybody's. Its rate
 * setpoint of pitch has the other sign, and angles are in degrees.
 */
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "FreeRTOS.h"
#include "app.h"
#include "commander.h"
#include "debug.h"
#include "log.h"
#include "param.h"
#include "policy.h"
#include "power_distribution.h"
#include "stabilizer_types.h"
#include "task.h"

#define DEBUG_MODULE "POLICY"
#define PRIORITY 3 /* of setpoints: above those of the radio, which is 1 */
#define RADIANS 0.01745329252f
#define DEGREES 57.2957795131f
#define PI 3.14159265359f

/* Logged values of the firmware. */
typedef struct {
  logVarId_t position[3], velocity[3], quaternion[4], rate[3], yaw;
} Signals;

static policy_state state;
static uint8_t fly;
static float goal_x, goal_y, goal_z = 0.5f, goal_yaw; /* m and rad */
static uint8_t refused;                               /* steps whose inputs were no numbers */

static void find(logVarId_t *ids, const char *group, const char *const *names, int count) {
  int i;
  for (i = 0; i < count; ++i) ids[i] = logGetVarId(group, names[i]);
}

static void find_signals(Signals *s) {
  static const char *const position[] = {"x", "y", "z"};
  static const char *const velocity[] = {"vx", "vy", "vz"};
  static const char *const quaternion[] = {"qw", "qx", "qy", "qz"};
  static const char *const yaw[] = {"yaw"};
  find(s->position, "stateEstimate", position, 3);
  find(s->velocity, "stateEstimate", velocity, 3);
  find(s->quaternion, "stateEstimate", quaternion, 4);
  find(s->rate, "gyro", position, 3);
  find(&s->yaw, "stateEstimate", yaw, 1);
}

/* An angle in -pi ... pi. */
static float wrapped(float angle) {
  while (angle > PI) angle -= 2.0f * PI;
  while (angle < -PI) angle += 2.0f * PI;
  return angle;
}

static void observe(const Signals *s, policy_input *input) {
  const float goal[3] = {goal_x, goal_y, goal_z};
  float sign;
  int i;
  for (i = 0; i < 3; ++i) {
    input->position_error[i] = goal[i] - logGetFloat(s->position[i]);
    input->velocity[i] = logGetFloat(s->velocity[i]);
    input->angular_velocity[i] = logGetFloat(s->rate[i]) * RADIANS;
  }
  input->yaw_error = wrapped(goal_yaw - logGetFloat(s->yaw) * RADIANS);
  sign = logGetFloat(s->quaternion[0]) < 0.0f ? -1.0f : 1.0f; /* w >= 0 */
  for (i = 0; i < 4; ++i) input->attitude[i] = sign * logGetFloat(s->quaternion[i]);
}

static void command(const policy_output *output) {
  setpoint_t setpoint;
  memset(&setpoint, 0, sizeof(setpoint)); /* no mode: position and attitude are not controlled */
  setpoint.mode.roll = modeVelocity;
  setpoint.mode.pitch = modeVelocity;
  setpoint.mode.yaw = modeVelocity;
  setpoint.attitudeRate.roll = output->rate_x * DEGREES;
  setpoint.attitudeRate.pitch = -output->rate_y * DEGREES;
  setpoint.attitudeRate.yaw = output->rate_z * DEGREES;
  setpoint.thrust = output->thrust / powerDistributionGetMaxThrust() * (float)UINT16_MAX;
  commanderSetSetpoint(&setpoint, PRIORITY);
}

void appMain(void) {
  const TickType_t period = M2T((uint32_t)(1000.0f * POLICY_PERIOD + 0.5f));
  static policy_input input;
  static policy_output output;
  Signals signals;
  TickType_t woken = xTaskGetTickCount();
  bool flew = false;
  find_signals(&signals);
  DEBUG_PRINT("policy: every %d ms\n", (int)(1000.0f * POLICY_PERIOD + 0.5f));
  for (;;) {
    vTaskDelayUntil(&woken, period);
    if (fly && !flew) policy_reset(&state);
    flew = fly != 0;
    if (!flew) continue;
    observe(&signals, &input);
    if (policy_step(&state, &input, &output)) {
      command(&output);
    } else {
      /* No setpoint: after half a second the firmware levels the vehicle, then it stops. */
      ++refused;
    }
  }
}

PARAM_GROUP_START(policy)
PARAM_ADD(PARAM_UINT8, fly, &fly)
PARAM_ADD(PARAM_FLOAT, x, &goal_x)
PARAM_ADD(PARAM_FLOAT, y, &goal_y)
PARAM_ADD(PARAM_FLOAT, z, &goal_z)
PARAM_ADD(PARAM_FLOAT, yaw, &goal_yaw)
PARAM_GROUP_STOP(policy)

LOG_GROUP_START(policy)
LOG_ADD(LOG_UINT8, refused, &refused)
LOG_GROUP_STOP(policy)
