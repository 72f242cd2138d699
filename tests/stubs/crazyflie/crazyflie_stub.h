/* Stubs of the interfaces of the Crazyflie's firmware that examples/deploy/crazyflie uses: the same
   names and types, of our own. */
#ifndef CRAZYFLIE_STUB_H
#define CRAZYFLIE_STUB_H

#include <stdbool.h>
#include <stdint.h>

/* FreeRTOS.h, task.h */
typedef uint32_t TickType_t;
#define M2T(X) ((TickType_t)(X)) /* 1 kHz */
TickType_t xTaskGetTickCount(void);
void vTaskDelayUntil(TickType_t *woken, TickType_t period);

/* app.h */
void appMain(void);

/* debug.h */
#define DEBUG_PRINT(...) ((void)0)

/* log.h, param.h */
typedef uint16_t logVarId_t;
logVarId_t logGetVarId(const char *group, const char *name);
float logGetFloat(logVarId_t id);
#define LOG_UINT8 1
#define LOG_GROUP_START(GROUP)
#define LOG_ADD(TYPE, NAME, ADDRESS) void *const logged_##NAME = ADDRESS;
#define LOG_GROUP_STOP(GROUP)
#define PARAM_UINT8 1
#define PARAM_FLOAT 2
#define PARAM_GROUP_START(GROUP)
#define PARAM_ADD(TYPE, NAME, ADDRESS) void *const parameter_##NAME = ADDRESS;
#define PARAM_GROUP_STOP(GROUP)

/* stabilizer_types.h */
typedef struct {
  uint32_t timestamp;
  float roll, pitch, yaw;
} attitude_t;
typedef enum { modeDisable = 0, modeAbs, modeVelocity } stab_mode_t;
typedef struct {
  uint32_t timestamp;
  attitude_t attitude;
  attitude_t attitudeRate; /* deg/s */
  float thrust;            /* 0 ... 65535 */
  struct {
    stab_mode_t x, y, z, roll, pitch, yaw, quat;
  } mode;
} setpoint_t;

/* commander.h, power_distribution.h */
void commanderSetSetpoint(setpoint_t *setpoint, int priority);
float powerDistributionGetMaxThrust(void); /* N */

#endif
