/* Runs the app for a few periods with states of standard input, and prints its setpoints.

   Input, a line for each period: fly goal_x goal_y goal_z goal_yaw, position (3), velocity (3),
   quaternion w x y z, rates [deg/s] (3), yaw [deg]. Output: thrust, rates of roll, pitch, yaw and
   modes of roll, pitch, yaw, z; or `none`. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "crazyflie_stub.h"

#define VALUES 14
static const char *const names[VALUES] = {
    "stateEstimate.x",  "stateEstimate.y",  "stateEstimate.z",  "stateEstimate.vx",
    "stateEstimate.vy", "stateEstimate.vz", "stateEstimate.qw", "stateEstimate.qx",
    "stateEstimate.qy", "stateEstimate.qz", "gyro.x",           "gyro.y",
    "gyro.z",           "stateEstimate.yaw"};
static float values[VALUES];
static int is_first = 1, was_commanded;
static setpoint_t last;

extern void *const parameter_fly, *const parameter_x, *const parameter_y, *const parameter_z,
                                                                              *const parameter_yaw;

TickType_t xTaskGetTickCount(void) { return 100; }

void vTaskDelayUntil(TickType_t *woken, TickType_t period) {
  float *const goal[4] = {parameter_x, parameter_y, parameter_z, parameter_yaw};
  int fly, i;
  *woken += period;
  if (!is_first && was_commanded) {
    printf("%.9g %.9g %.9g %.9g %d %d %d %d\n", (double)last.thrust, (double)last.attitudeRate.roll,
           (double)last.attitudeRate.pitch, (double)last.attitudeRate.yaw, last.mode.roll,
           last.mode.pitch, last.mode.yaw, last.mode.z);
  } else if (!is_first) {
    printf("none\n");
  } else {
    printf("period %u\n", (unsigned)period);
  }
  is_first = was_commanded = 0;
  if (scanf("%d", &fly) != 1) exit(0);
  *(uint8_t *)parameter_fly = (uint8_t)fly;
  for (i = 0; i < 4; ++i)
    if (scanf("%f", goal[i]) != 1) exit(1);
  for (i = 0; i < VALUES; ++i)
    if (scanf("%f", &values[i]) != 1) exit(1);
}

logVarId_t logGetVarId(const char *group, const char *name) {
  char whole[40];
  int i;
  snprintf(whole, sizeof(whole), "%s.%s", group, name);
  for (i = 0; i < VALUES; ++i)
    if (strcmp(whole, names[i]) == 0) return (logVarId_t)i;
  exit(2);
}

float logGetFloat(logVarId_t id) { return values[id]; }

void commanderSetSetpoint(setpoint_t *setpoint, int priority) {
  last = *setpoint;
  was_commanded = priority > 1;
}

float powerDistributionGetMaxThrust(void) { return 0.6f; }

int main(void) {
  appMain();
  return 0;
}
