/* The list of signals between controllers, and from controllers to actuators. Plain C, part of
 * abi.h. Normative units and frames: docs/control-modes.md.
 *
 * A row: symbol, C++ name, word, minimum and maximum number of values, meaning. Maximum 0: any
 * multiple of the minimum; minimum 0, too: the number depends on the robot. */
#ifndef SKYBODY_PLUGIN_ABI_SIGNALS_H
#define SKYBODY_PLUGIN_ABI_SIGNALS_H

#define SKYBODY_REFERENCE_VALUES 17 /* of one point of a trajectory */

// clang-format off
#define SKYBODY_SIGNALS(X) \
  X(ROTOR_SPEED,       RotorSpeed,       rotor_speed,       0,  0, "one per rotor [rad/s]; as an output: drives the rotors") \
  X(SRT,               Srt,              srt,               0,  0, "single rotor thrusts, one per rotor along its axis [N]") \
  X(CTBT,              Ctbt,             ctbt,              4,  4, "collective thrust [N], body torque (B axes) [N m]") \
  X(CTBR,              Ctbr,             ctbr,              4,  4, "collective thrust [N], body rates (B axes) [rad/s]") \
  X(WRENCH,            Wrench,           wrench,            0,  0, "6 per site: force [N], moment [N m]; as an output: drives the sites") \
  X(VELOCITY,          Velocity,         velocity,          6,  6, "v [m/s], w [rad/s], B axes; as an output: drives the base") \
  X(POSE,              Pose,             pose,              7,  7, "position (W) [m], quaternion w x y z; as an output: drives the base") \
  X(ATTITUDE,          Attitude,         attitude,          5,  8, "collective thrust [N], quaternion w x y z, optionally body rates (B axes) [rad/s]") \
  X(POSITION,          Position,         position,          4,  4, "position (W) [m], yaw [rad]") \
  X(TRAJECTORY,       Trajectory,       trajectory,       17,  0, "one or several points, each: position, velocity, acceleration, jerk, snap (W), yaw [rad], yaw rate [rad/s]") \
  X(FORCE,             Force,            force,             3,  4, "total force of the rotors (W) [N], optionally yaw [rad]") \
  X(ACCELERATION,      Acceleration,     acceleration,      4,  4, "acceleration (W) [m/s^2], yaw [rad]") \
  X(VELOCITY_TRACKING, VelocityTracking, velocity_tracking, 4,  4, "velocity (W) [m/s], yaw rate [rad/s]") \
  X(JOINT,             Joint,            joint,             0,  0, "one per joint drive: rad or m, rad/s or m/s, N m or N; as an output: drives the joints") \
  X(THROTTLE,          Throttle,         throttle,          0,  0, "one per rotor: fraction of its largest speed, 0 to 1") \
  X(NONE,              None,             none,              0,  0, "no values: input of a chain that takes no command")
// clang-format on

enum SkybodySignal {
#define SKYBODY_ROW(symbol, type, word, least, most, doc) SKYBODY_##symbol,
  SKYBODY_SIGNALS(SKYBODY_ROW)
#undef SKYBODY_ROW
      SKYBODY_SIGNAL_COUNT
};

#endif /* SKYBODY_PLUGIN_ABI_SIGNALS_H */
