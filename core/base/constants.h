/* The physical constants of the world, of robots, bodies, joints, rotors, obstacles and couplings,
 * one row each. Plain C.
 *
 * These tables define:
 * - indices of EnvParams (enums here by SYMBOL, in core/model/constants.h by Id), and paths
 * - the keys of scenario and rotors files, and their checks
 * - the JSON schema and the tables of docs/scenarios.md
 * A new constant needs one row, and the force that reads it.
 *
 *   X(SYMBOL, Id, key, unit, count, fallback, least, greatest, least_drawn, doc)
 *
 * - key: the name in files, and the end of an EnvParam's path, after the path of its owner; with
 *   several values the paths end in [0], [1], ...
 * - count: number of values, at most 6; six values are a symmetric matrix: xx yy zz xy xz yz
 * - fallback: the default values, in parentheses; (): files must give the values
 * - least, greatest: inclusive bounds of each value in a file
 * - least_drawn: inclusive lower bound of a drawn EnvParam, for a symmetric matrix of its diagonal;
 *   there is no upper bound
 * - doc: one line
 */
#ifndef SKYBODY_CORE_BASE_CONSTANTS_H
#define SKYBODY_CORE_BASE_CONSTANTS_H

/* Lower bound of a drawn mass, moment of inertia or largest speed: positive, and far below the
 * values of any vehicle. */
#define SKYBODY_LEAST_POSITIVE 1e-12
/* The shortest rod, rope or spring [m]: below this length the direction is undefined. */
#define SKYBODY_LEAST_LENGTH 1e-6
/* Bound of quantities without a natural bound. */
#define SKYBODY_FAR 1e6

/* clang-format off */

/* Paths: gravity[2], contact.friction. */
#define SKYBODY_WORLD_CONSTANTS(X)                                                                 \
  X(SKYBODY_WORLD_GRAVITY, kGravity, "gravity", "m/s^2", 3, (0, 0, -9.81), -1000, 1000, -INFINITY, \
    "acceleration of gravity, axes of W")                                                          \
  X(SKYBODY_WORLD_DISSIPATION, kDissipation, "contact.dissipation", "s/m", 1, (3), 0, 100, 0,      \
    "Hunt-Crossley dissipation c")                                                                 \
  X(SKYBODY_WORLD_FRICTION, kFriction, "contact.friction", "", 1, (0.6), 0, 10, 0,                 \
    "Coulomb coefficient")

/* Paths: robots.quad.disturbance.force[0]. Paper eq. 1. */
#define SKYBODY_ROBOT_CONSTANTS(X)                                                                 \
  X(SKYBODY_ROBOT_DISTURBANCE_FORCE, kDisturbanceForce, "disturbance.force", "N", 3, (0, 0, 0),    \
    -SKYBODY_FAR, SKYBODY_FAR, -INFINITY, "force on the base's centre of mass, axes of W")         \
  X(SKYBODY_ROBOT_DISTURBANCE_MOMENT, kDisturbanceMoment, "disturbance.moment", "N m", 3,          \
    (0, 0, 0), -SKYBODY_FAR, SKYBODY_FAR, -INFINITY, "moment on the base, axes of the base")

/* Paths: robots.quad.links.base_link.mass. Files: from the URDF, see core/io/yaml/ranges.h. */
#define SKYBODY_BODY_CONSTANTS(X)                                                                  \
  X(SKYBODY_BODY_MASS, kMass, "mass", "kg", 1, (), 1e-20, 1e12, SKYBODY_LEAST_POSITIVE,            \
    "mass of the body")                                                                            \
  X(SKYBODY_BODY_COM, kCom, "com", "m", 3, (), -SKYBODY_FAR, SKYBODY_FAR, -INFINITY,               \
    "centre of mass, body frame")                                                                  \
  X(SKYBODY_BODY_INERTIA, kInertia, "inertia", "kg m^2", 6, (), -1e24, 1e24,                       \
    SKYBODY_LEAST_POSITIVE, "about the centre of mass, axes of the body")

/* Paths: robots.quad.joints.elbow.damping. The joint's type selects the rows that apply:
 * - damping: every moving joint except a free base
 * - stiffness, rest: revolute and prismatic joints
 * - limit_stiffness, limit_damping: joints with limits */
#define SKYBODY_JOINT_CONSTANTS(X)                                                                 \
  X(SKYBODY_JOINT_DAMPING, kJointDamping, "damping", "N m s/rad or N s/m", 1, (0), 0, SKYBODY_FAR, \
    0, "viscous, every coordinate")                                                                \
  X(SKYBODY_JOINT_STIFFNESS, kJointStiffness, "stiffness", "N m/rad or N/m", 1, (0), 0,            \
    SKYBODY_FAR, 0, "spring to `rest`; revolute and prismatic joints")                             \
  X(SKYBODY_JOINT_REST, kJointRest, "rest", "rad or m", 1, (0), -SKYBODY_FAR, SKYBODY_FAR,         \
    -INFINITY, "position at which the spring is relaxed")                                          \
  X(SKYBODY_JOINT_LIMIT_STIFFNESS, kLimitStiffness, "limit_stiffness", "N m/rad or N/m", 1, (0),   \
    0, 1e9, 0, "stiffness of the spring beyond the limits")                                        \
  X(SKYBODY_JOINT_LIMIT_DAMPING, kLimitDamping, "limit_damping", "N m s/rad or N s/m", 1, (0), 0,  \
    1e9, 0, "constant of the damper beyond the limits")

/* Paths: robots.quad.rotors[2].thrust_constant. RotorS, Furrer et al. 2016, "Rotor dynamics". */
#define SKYBODY_ROTOR_CONSTANTS(X)                                                                 \
  X(SKYBODY_ROTOR_THRUST_CONSTANT, kThrustConstant, "thrust_constant", "N s^2/rad^2", 1, (),       \
    1e-18, 1, 0, "k_f, thrust = k_f w^2")                                                          \
  X(SKYBODY_ROTOR_MOMENT_CONSTANT, kMomentConstant, "moment_constant", "N m s^2/rad^2", 1, (), 0,  \
    1, 0, "k_m, drag torque about the axis = k_m w^2")                                             \
  X(SKYBODY_ROTOR_DRAG_CONSTANT, kDragConstant, "drag_constant", "N s^2/(m rad)", 1, (0), 0, 1, 0, \
    "rotor drag, force = -c w v_perp")                                                             \
  X(SKYBODY_ROTOR_ROLLING_MOMENT_CONSTANT, kRollingMomentConstant, "rolling_moment_constant",      \
    "N m s^2/(m rad)", 1, (0), 0, 1, 0, "rolling moment = -direction c w v_perp")                  \
  X(SKYBODY_ROTOR_INERTIA, kRotorInertia, "inertia", "kg m^2", 1, (0), 0, 100, 0,                  \
    "about the axis; 0 leaves gyroscopic terms out")                                               \
  X(SKYBODY_ROTOR_MAX_SPEED, kMaxSpeed, "max_speed", "rad/s", 1, (), 1e-3, 1e5,                    \
    SKYBODY_LEAST_POSITIVE, "largest speed")                                                       \
  X(SKYBODY_ROTOR_TAU_UP, kTauUp, "tau_up", "s", 1, (0), 0, 100, 0,                                \
    "time constant while speeding up; 0: immediate")                                               \
  X(SKYBODY_ROTOR_TAU_DOWN, kTauDown, "tau_down", "s", 1, (0), 0, 100, 0,                          \
    "time constant while slowing down; 0: immediate")                                              \
  X(SKYBODY_ROTOR_POSITION, kRotorPosition, "position", "m", 3, (), -1000, 1000, -INFINITY,        \
    "position of the hub; in files in the frame of its link, otherwise in the frame of the body")

/* Paths: obstacles.pole.position[0]. In files: the keys `shape` and `pose` of `obstacles`. */
#define SKYBODY_OBSTACLE_CONSTANTS(X)                                                              \
  X(SKYBODY_OBSTACLE_PRESENT, kObstaclePresent, "present", "", 1, (1), 0, 1, 0,                    \
    "1: present; 0: absent")                                                                       \
  X(SKYBODY_OBSTACLE_POSITION, kObstaclePosition, "position", "m", 3, (), -SKYBODY_FAR,            \
    SKYBODY_FAR, -INFINITY, "position of its centre, W")                                           \
  X(SKYBODY_OBSTACLE_ROTATION, kObstacleRotation, "rotation", "", 4, (), -1, 1, -INFINITY,         \
    "quaternion w x y z, W from the obstacle; normalized")                                         \
  X(SKYBODY_OBSTACLE_SIZE, kObstacleSize, "size", "m", 3, (), 1e-9, SKYBODY_FAR, 0,                \
    "box: edge lengths; cylinder, capsule: radius, length; sphere: radius; gate: width, height, "  \
    "thickness; height_field: along x and y; plane: none")

/* Paths: couplings.tether.length. Points have `present`; rods and ropes `present` and `length`;
 * springs all rows. */
#define SKYBODY_COUPLING_CONSTANTS(X)                                                              \
  X(SKYBODY_COUPLING_PRESENT, kCouplingPresent, "present", "", 1, (1), 0, 1, 0,                    \
    "1: present; 0: absent")                                                                       \
  X(SKYBODY_COUPLING_LENGTH, kCouplingLength, "length", "m", 1, (), SKYBODY_LEAST_LENGTH,          \
    SKYBODY_FAR, SKYBODY_LEAST_LENGTH,                                                             \
    "distance between the ends; rope: the largest one; spring: the one at which it is relaxed")    \
  X(SKYBODY_COUPLING_STIFFNESS, kCouplingStiffness, "stiffness", "N/m", 1, (0), 0, SKYBODY_FAR, 0, \
    "stiffness of a spring")                                                                       \
  X(SKYBODY_COUPLING_DAMPING, kCouplingDamping, "damping", "N s/m", 1, (0), 0, SKYBODY_FAR, 0,     \
    "damping of a spring, along its line")

/* clang-format on */

/* Indices of a table's values, counted through all rows: of a constant's first and last value. */
#define SKYBODY_PLACE(SYMBOL, Id, key, unit, count, fallback, least, greatest, least_drawn, doc) \
  SYMBOL, SYMBOL##_LAST = SYMBOL + (count)-1,

#ifdef __cplusplus
extern "C" {
#endif

enum SkybodyWorldConstant { SKYBODY_WORLD_CONSTANTS(SKYBODY_PLACE) SKYBODY_WORLD_CONSTANT_COUNT };
enum SkybodyRobotConstant { SKYBODY_ROBOT_CONSTANTS(SKYBODY_PLACE) SKYBODY_ROBOT_CONSTANT_COUNT };
enum SkybodyBodyConstant { SKYBODY_BODY_CONSTANTS(SKYBODY_PLACE) SKYBODY_BODY_CONSTANT_COUNT };
enum SkybodyJointConstant { SKYBODY_JOINT_CONSTANTS(SKYBODY_PLACE) SKYBODY_JOINT_CONSTANT_COUNT };
enum SkybodyRotorConstant { SKYBODY_ROTOR_CONSTANTS(SKYBODY_PLACE) SKYBODY_ROTOR_CONSTANT_COUNT };
enum SkybodyObstacleConstant {
  SKYBODY_OBSTACLE_CONSTANTS(SKYBODY_PLACE) SKYBODY_OBSTACLE_CONSTANT_COUNT
};
enum SkybodyCouplingConstant {
  SKYBODY_COUPLING_CONSTANTS(SKYBODY_PLACE) SKYBODY_COUPLING_CONSTANT_COUNT
};

#ifdef __cplusplus
}
#endif

#endif /* SKYBODY_CORE_BASE_CONSTANTS_H */
