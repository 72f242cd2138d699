/* The binary contract between Skybody and a plugin. Plain C only.
 *
 * A plugin is a shared library that exports one object, `skybody_plugin_library`. Before any call
 * the host checks magic, ABI version, structure sizes and the floating-point probe. A structure
 * that is added here is also added to <core/plugin_abi/structures.h>. Authors include
 * <skybody/plugin.h>, which fills in these structures, and not this file.
 *
 * Values lie in lanes: scalar k of lane l of a group of L lanes is at p[k * L + l]. A step function
 * serves every lane whose bit is set in `active` and must not write to the others. Exceptions: the
 * output of control() and the results of evaluate().
 *
 * Functions on dual numbers (SkybodyNumber) serve full groups only. Each value in lanes then has
 * two rows: the value at p[2 k * L + l] and its tangent at p[(2 k + 1) * L + l]. This holds for all
 * doubles and for the words of `state`; the tangent of a word that is not a double is neither read
 * nor written. Keys, counters, `active` and `end` keep one row.
 *
 * Step functions (`SkybodyKernels`) are called concurrently on one instance from several threads.
 * They do not allocate, lock, log, throw or keep data: all mutable data is in `state`. */
#ifndef SKYBODY_PLUGIN_ABI_ABI_H
#define SKYBODY_PLUGIN_ABI_ABI_H

#include <stddef.h>
#include <stdint.h>

#include "core/base/constants.h"
#include "core/base/held_inputs.h"
#include "core/base/plugin_kinds.h"
#include "core/base/simd/isa_sets.h"
#include "core/plugin_abi/signals.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SKYBODY_ABI_MAGIC UINT64_C(0x59444f4259424b53) /* "SKBYBODY", little endian */
#define SKYBODY_ABI_VERSION 8u
#define SKYBODY_GROUP_LANES 32u   /* lanes of a full group; the only other number of lanes is 1 */
#define SKYBODY_CONTACT_VALUES 7  /* per body in SkybodyLanes::contacts */
#define SKYBODY_REACTION_VALUES 6 /* per joint in SkybodyLanes::joint_reactions */
#define SKYBODY_LONGEST_LEFT_OUT 1024 /* physics steps, see SkybodyDeclare::only_when_read */
#define SKYBODY_NEVER_READ UINT64_MAX /* see SkybodyLanes::steps_to_read */
#define SKYBODY_DRAW_AGAIN (UINT64_MAX - 1)
#define SKYBODY_LIBRARY_SYMBOL "skybody_plugin_library"

enum SkybodyParameterType {
  SKYBODY_REAL = 0,
  SKYBODY_INTEGER = 1, /* handed over as double, exact */
  SKYBODY_BOOLEAN = 2, /* 0 or 1 as double */
  SKYBODY_TEXT = 3
};

/* One declared parameter. A vector has min_count != 1 or max_count != 1; max_count -1: any length.
 */
typedef struct SkybodyParameter {
  const char* name;
  const char* unit; /* "" for a pure number */
  const char* doc;  /* one line */
  uint32_t type;    /* SkybodyParameterType */
  int32_t min_count;
  int32_t max_count;
  uint32_t required;     /* 1: no default */
  uint32_t randomizable; /* 1: one value per environment, in state words; 2: only where the scenario
                            sets it, otherwise the default for all; reals only */
  uint32_t is_file;      /* 1: the texts are file names; the host passes paths that can be opened */
  double min;            /* inclusive */
  double max;            /* inclusive */
  const double* default_numbers;
  const char* const* default_texts;
  uint32_t default_count;
  const char* const* choices; /* texts only; NULL: anything */
  uint32_t choice_count;
} SkybodyParameter;

/* A parameter's value, in the order of the declarations. */
typedef struct SkybodyValue {
  const double* numbers;
  const char* const* texts;
  uint32_t count;
  int32_t env_param; /* first index into SkybodyLanes::params if randomizable, else -1 */
  uint32_t is_given; /* 1: set by the scenario; 0: the default */
} SkybodyValue;

/* Joint types: the motion of a body relative to its parent. */
enum SkybodyJointType {
  SKYBODY_WELD = 0,      /* no motion: a fixed base */
  SKYBODY_FREE = 1,      /* six degrees of freedom: a base, or a link on a floating joint */
  SKYBODY_PIN = 2,       /* rotates about z of the joint's frame */
  SKYBODY_SLIDER = 3,    /* translates along x of the joint's frame */
  SKYBODY_UNIVERSAL = 4, /* rotates about x of the joint's frame, then about the new y */
  SKYBODY_BALL = 5       /* rotates about any axis */
};

/* One rigid body: all links connected by fixed joints. */
typedef struct SkybodyBodyInfo {
  const char* name;          /* name of the link whose frame is the body frame */
  int32_t robot;             /* index of its robot */
  int32_t parent;            /* world body index or -1 */
  double mass;               /* nominal [kg] */
  double com[3];             /* [m], body frame */
  double inertia[6];         /* about com: xx yy zz xy xz yz [kg m^2] */
  int32_t first_param;       /* EnvParams, at the places of SkybodyBodyConstant */
  int32_t first_q;           /* within the q block */
  int32_t first_u;           /* within the u block */
  int32_t joint;             /* SkybodyJointType of its inboard joint */
  int32_t first_joint_param; /* EnvParams of that joint, at the places of SkybodyJointConstant */
  int32_t joint_param_count; /* number of these EnvParams that apply to this joint, counted from the
                                first */
  const char* joint_name;    /* "" of a base */
  int32_t joint_is_limited;  /* pin and slider: 1: it has limits */
  double joint_lower, joint_upper; /* [rad] or [m] */
  double joint_start;              /* pin and slider: its coordinate at a reset [rad] or [m] */
  double joint_in_parent[7]; /* joint frame on the parent's side, in the parent's frame (fixed base:
                                in W): position [m], quaternion w x y z */
  double joint_in_body[7];   /* joint frame on this body's side, in the body frame: position [m],
                                quaternion w x y z; the two frames coincide where the joint's
                                coordinates are 0 */
} SkybodyBodyInfo;

/* A link of the URDF. */
typedef struct SkybodyLinkInfo {
  const char* name;   /* in the URDF */
  int32_t robot;      /* index of its robot */
  int32_t body;       /* world body index */
  double position[3]; /* link frame in the body's frame [m] */
  double rotation[4]; /* body frame from link frame, w x y z */
  double com[3];      /* centre of mass of the link alone, in the body's frame [m] */
} SkybodyLinkInfo;

/* One rotor. */
typedef struct SkybodyRotorInfo {
  const char* name;           /* in the rotors file */
  int32_t robot;              /* index of its robot */
  int32_t body;               /* world body that carries it */
  double position[3];         /* body frame [m] */
  double axis[3];             /* body frame, unit */
  double position_in_base[3]; /* in the frame of the robot's base, joints at their reset position
                                 [m] */
  double
      axis_in_base[3]; /* in the frame of the robot's base, joints at their reset position, unit */
  double direction;    /* +1 counter-clockwise about the axis, -1 clockwise */
  double min_speed;    /* below 0: the rotor can turn backwards and then pushes against the axis
                          [rad/s] */
  double constants[SKYBODY_ROTOR_CONSTANT_COUNT]; /* at the places of SkybodyRotorConstant */
  int32_t first_param;                            /* EnvParams, at the same places */
} SkybodyRotorInfo;

/* One robot and the places of its bodies, rotors and coordinates in the world's arrays. */
typedef struct SkybodyRobotInfo {
  const char* name;                 /* in the scenario */
  int32_t first_body, body_count;   /* the base first */
  int32_t first_rotor, rotor_count; /* in the order of the rotors file */
  int32_t first_q, q_count;         /* places of SkybodyLanes::q */
  int32_t first_u, u_count;         /* their rates */
  int32_t first_param;              /* EnvParams, at the places of SkybodyRobotConstant */
  int32_t fixed_base;               /* 1: the base is not free */
  double position[3];               /* of the base at reset [m], W */
  double rotation[4];               /* W from B, w x y z */
  int32_t first_action;             /* within the action row; for tasks and randomizers, else 0 */
  int32_t action_count;             /* values of its action */
  int32_t first_chain, chain_count; /* for tasks and randomizers, else 0 */
} SkybodyRobotInfo;

typedef struct SkybodySensorInfo {
  const char* name;    /* instance */
  const char* channel; /* such as specific_force */
  int32_t first;       /* within SkybodyLanes::sensors */
  int32_t count;
} SkybodySensorInfo;

/* Consecutive controllers of one robot or team, from a command to actuators. */
typedef struct SkybodyChainInfo {
  int32_t robot;         /* index of its robot; for a team the first robot */
  int32_t signal;        /* SkybodySignal of its first controller */
  int32_t first_command; /* within the command block, and within an action that the task does not
                            declare */
  int32_t count;         /* number of command values */
} SkybodyChainInfo;

/* Kinds of shapes and the meaning of their sizes. */
enum SkybodyShapeKind {
  SKYBODY_BOX = 0,      /* size: edge lengths [m] */
  SKYBODY_CYLINDER = 1, /* size: radius, length along z [m], 0 */
  SKYBODY_SPHERE = 2,   /* size: radius [m], 0, 0 */
  SKYBODY_MESH = 3,     /* size: scale factors */
  SKYBODY_GATE = 4, /* obstacles only; size: width (y) and height (z) of the opening, thickness */
  SKYBODY_CAPSULE = 5,     /* size: radius, length along z between the centres of its caps [m], 0 */
  SKYBODY_PLANE = 6,       /* obstacles only: the half-space below z = 0 of its frame; size: 0 */
  SKYBODY_HEIGHT_FIELD = 7 /* obstacles only: the space below heights on a grid; size: extents along
                              x and y [m], greatest height [m] */
};

/* A collision shape of a body, or an obstacle. Its index among all shapes is its id. */
typedef struct SkybodyShapeInfo {
  const char* name; /* of the body or the obstacle */
  const char* mesh; /* file, or "" */
  int32_t kind;     /* SkybodyShapeKind */
  int32_t robot;    /* index of its robot; -1: an obstacle */
  int32_t body;     /* world body index; -1: an obstacle */
  int32_t
      obstacle; /* index among the obstacles (SkybodyDeclare::contact_pair); -1: a body's shape */
  int32_t first_param; /* EnvParams of an obstacle, at the places of SkybodyObstacleConstant:
                          presence, pose, size; -1: a body's shape, which is fixed */
  double size[3];      /* nominal, see SkybodyShapeKind */
  double position[3];  /* of its frame, in the body frame; obstacles: in W [m] */
  double rotation[4];  /* body frame (obstacles: W) from the shape's frame, w x y z */
} SkybodyShapeInfo;

/* A shape to draw: a visual of a body, or a collision shape of a body without visuals, or with a
 * mesh of a format that is not read. Obstacles are drawn as in SkybodySetup::shapes. */
typedef struct SkybodyVisualInfo {
  SkybodyShapeInfo shape; /* `obstacle` and `first_param` are -1 */
  double color[4];        /* red, green, blue, opacity, each in [0, 1] */
  const char* texture;    /* file of the picture on it (SkybodySetup::picture), or "" */
} SkybodyVisualInfo;

/* A picture for textures: rows from the top, pixels from the left. */
typedef struct SkybodyPicture {
  const uint8_t* rgb;    /* red, green, blue of each pixel */
  int32_t width, height; /* [pixels]; 0 with a problem */
  const char* problem;   /* such as "does not exist"; "" if there is none */
} SkybodyPicture;

/* Triangles to draw. */
typedef struct SkybodyTriangles {
  const float* corners; /* nine numbers per triangle: x, y, z of each corner, unscaled [m] */
  const float* texture; /* six numbers per triangle: u to the right and v up of each corner, from 0
                           to 1; NULL: none */
  int32_t count;        /* 0 with a problem */
  const char* problem;  /* such as "has no faces"; "" if there is none */
} SkybodyTriangles;

/* A randomizable value. */
typedef struct SkybodyEnvParamInfo {
  const char* path;  /* such as robots.quad.rotors[2].thrust_constant */
  const char* alias; /* robots.quad.rotors.rear_left.thrust_constant, or "" */
  double nominal;    /* the scenario's value, in SI units */
  double min;        /* lower bound of draws */
  double max;        /* upper bound of draws */
} SkybodyEnvParamInfo;

/* The world, as passed to configure(). The structure and all its pointers are valid during create()
 * only: an instance copies the data that it needs later. */
typedef struct SkybodySetup {
  const char* instance; /* unique in the world: the key of this instance's random numbers */
  double dt;            /* physics step [s] */
  int32_t action_repeat;
  int32_t horizon;           /* steps until truncation, 0: none */
  double gravity[3];         /* nominal [m/s^2], W */
  int32_t first_world_param; /* EnvParams, at the places of SkybodyWorldConstant */
  const int32_t* team;       /* controllers: the robots served, in order; other kinds: empty */
  int32_t team_size;
  const SkybodyRobotInfo* robots;
  int32_t robot_count;
  const SkybodyBodyInfo* bodies;
  int32_t body_count;
  const SkybodyLinkInfo* links;
  int32_t link_count;
  const SkybodyRotorInfo* rotors;
  int32_t rotor_count;
  const SkybodySensorInfo* sensors; /* for other kinds and for sensors that come later */
  int32_t sensor_count;
  const SkybodyChainInfo* chains; /* for tasks and randomizers */
  int32_t chain_count;
  const SkybodyShapeInfo* shapes; /* of bodies, in body order, then obstacles */
  int32_t shape_count;
  const SkybodyVisualInfo* visuals; /* in body order */
  int32_t visual_count;
  const SkybodyEnvParamInfo* params;
  int32_t param_count;
  const SkybodyValue* values; /* this plugin's parameters */
  int32_t value_count;
  /* The triangles of a visual of the kind SKYBODY_MESH, and those of an obstacle of the kind
   * SKYBODY_HEIGHT_FIELD (by its index among the obstacles). Files are read at the first call. */
  const SkybodyTriangles* (*visual_triangles)(void* tables, int32_t visual);
  const SkybodyTriangles* (*obstacle_triangles)(void* tables, int32_t obstacle);
  /* The picture of a PNG or JPEG file. A file is read once for all plugins. */
  const SkybodyPicture* (*picture)(void* tables, const char* file);
  void* tables;
} SkybodySetup;

/* Element types of images. Vectors are doubles in lanes, and float32 for learners. */
enum SkybodyColumnType {
  SKYBODY_FLOAT32 = 0,
  SKYBODY_UINT8 = 1,
  SKYBODY_UINT16 = 2,
  SKYBODY_COLUMN_TYPE_COUNT = 3
};

/* A vector declared in configure(), with bounds for the spaces, or an image of a sensor. */
typedef struct SkybodyChannel {
  const char* name;
  const char* unit;
  int32_t count;
  double low; /* bounds of the values; -inf, inf where there are none */
  double high;
  int32_t robot; /* owner, where each robot has its own observation; -1: all robots */
  uint32_t
      privileged; /* 1: part of an observation for the critic only; the policy does not see it */
  uint32_t type;  /* SkybodyColumnType; vectors: SKYBODY_FLOAT32 */
  int32_t rank;   /* 0: a vector; 1 to 3: an image of `count` values, the product of its extents */
  int32_t shape[3]; /* the first `rank` entries are the extents; the last one varies fastest */
  const char* doc;  /* meaning of the values, for tables of observations and infos; "": none */
} SkybodyChannel;

/* Possible contact partners of a body. */
enum SkybodyPartner {
  SKYBODY_GROUND = 0,
  SKYBODY_OTHER_BODY = 1,
  SKYBODY_OBSTACLE = 2,
  SKYBODY_PARTNER_COUNT = 3
};

/* Point of application of a wrench. */
typedef struct SkybodySite {
  int32_t body;       /* world body index */
  double point[3];    /* body frame [m] */
  int32_t at_com;     /* 1: acts at the current centre of mass, `point` is ignored */
  int32_t world_axes; /* 1: force and moment in W; 0: in the body's axes */
} SkybodySite;

/* Meaning of the command of a joint drive. */
enum SkybodyJointMode {
  SKYBODY_JOINT_POSITION = 0, /* [rad] or [m] */
  SKYBODY_JOINT_VELOCITY = 1, /* [rad/s] or [m/s] */
  SKYBODY_JOINT_EFFORT = 2    /* [N m] or [N] */
};

/* A drive of one coordinate of a pin, slider or universal joint. With r the command after its lag:
 *   position  effort = clamp(stiffness (r - q) - damping u)
 *   velocity  effort = clamp(damping (r - u))
 *   effort    effort = clamp(r)
 * to [-effort_limit, effort_limit]. */
typedef struct SkybodyJointDrive {
  int32_t body;        /* world body index: the drive acts on its inboard joint */
  int32_t coordinate;  /* 0; universal joints: 0 or 1 */
  int32_t mode;        /* SkybodyJointMode */
  double stiffness;    /* [N m/rad] or [N/m], >= 0 */
  double damping;      /* [N m s/rad] or [N s/m], >= 0 */
  double effort_limit; /* [N m] or [N], > 0, may be infinite */
  double tau;          /* time constant of the first-order lag [s]; 0: none */
  double low, high;    /* the command is clamped to these bounds */
} SkybodyJointDrive;

/* Declarations that configure() makes. Texts are copied during the call. */
typedef struct SkybodyDeclare {
  void* host;
  /* Controllers: the command, and the physical values of action -1 and +1 per component. NULL for
   * both: the ranges of the next controller, to which this one passes its command on. */
  void (*input)(void* host, int32_t signal, int32_t count, const double* low, const double* high);
  /* Controllers: an output for one robot that it serves. Its receiver: the next controller, or the
   * robot's own chain that takes this signal, or the robot's actuators. */
  void (*output)(void* host, int32_t robot, int32_t signal, int32_t count);
  void (*site)(void* host, const SkybodySite* site);
  void (*joint)(void* host, const SkybodyJointDrive* drive);
  /* Sensors: outputs. Tasks: parts of the observation, in order. */
  void (*channel)(void* host, const SkybodyChannel* channel);
  /* Sensors: called after every `period` physics steps. Controllers and effects: called before
   * every such step; the last output holds in between. Tasks: period of process(); without it
   * process() is called once per action. */
  void (*period)(void* host, int32_t physics_steps);
  /* Any kind: words of state besides State, accessible as a buffer of doubles. */
  void (*buffer)(void* host, int32_t words);
  /* Any kind: doubles for use during a call, SkybodyLanes::scratch. Their content is not kept. */
  void (*scratch)(void* host, int32_t values);
  /* Sensors for plain double: doubles in a row for a call, in the place of scratch. */
  void (*scratch_block)(void* host, int32_t values);
  /* Any kind: doubles that are kept from call to call but are not state, SkybodyLanes::memo. */
  void (*memo)(void* host, int32_t values);
  /* Effects: an input that apply() fills, SkybodyHeldInput. */
  void (*holds)(void* host, int32_t input);
  /* Effects: the output of apply() depends on EnvParams only. It is called before the first physics
   * step of an episode and before a step ahead of which EnvParams may have changed. */
  void (*steady)(void* host);
  /* Any kind but tasks: the next `info` values are these words of the buffer. */
  void (*report)(void* host, const SkybodyChannel* info, int32_t first_word);
  /* Any kind: requests SkybodyLanes::contacts. */
  void (*contacts)(void* host);
  /* Any kind: requests the contact forces on `body` from one SkybodyPartner. `other` is a world
   * body or the index of an obstacle. Returns the pair's place in SkybodyLanes::contact_pairs. */
  int32_t (*contact_pair)(void* host, int32_t body, int32_t partner, int32_t other);
  /* Any kind: requests the force and moment that the inboard joint of `body` exerts on it. Returns
   * the place in SkybodyLanes::joint_reactions. */
  int32_t (*joint_reaction)(void* host, int32_t body);
  /* Tasks: a part of the action, in robot order, with the physical values of -1 and +1. Without
   * such a call the action consists of the chains' commands. With it process() is required and
   * receives physical values. */
  void (*action)(void* host, const SkybodyChannel* action);
  /* Tasks: the command is interpolated linearly from the previous to the current one over the
   * physics steps of an action. */
  void (*interpolate)(void* host);
  /* Any kind: requests SkybodyLanes::bodies_before. */
  void (*bodies_before)(void* host);
  /* Any kind: the plugin reads this sensor output, given by its first value within
   * SkybodyLanes::sensors. */
  void (*reads)(void* host, int32_t first);
  /* Sensors: a call whose output has no reader may be skipped, for at most SKYBODY_LONGEST_LEFT_OUT
   * physics steps. */
  void (*only_when_read)(void* host);
  /* Randomizers: this parameter will be written. It is clamped to its bounds after each draw. Two
   * writers of one parameter are an error. */
  void (*writes)(void* host, int32_t env_param);
  /* Randomizers: requests a call before every physics step, too. */
  void (*draws_in_time)(void* host);
  /* Tasks: the body of `robot` that the goal refers to, and the point of that body (body frame, 3
   * values, [m]) that should reach the target; goal() returns the pose of the body's frame. */
  void (*goal)(void* host, int32_t robot, int32_t body, const double* point);
  /* Tasks: evaluate() will write SkybodyEvaluation::robot_reward. */
  void (*robot_rewards)(void* host);
  /* Tasks: values besides the observation, for users and evaluations, in order. */
  void (*info)(void* host, const SkybodyChannel* channel);
  /* Tasks: `count` values of the observation from `to` on repeat those from `from` on. Packs of
   * lanes may leave them unwritten; single lanes and dual numbers write them. */
  void (*repeat)(void* host, int32_t to, int32_t from, int32_t count);
  /* Effects: the buffer's words from `first_word` on are `name` of `robot`, for sensors. The name
   * begins with that of the plugin, such as battery.charge. */
  void (*offers)(void* host, const char* name, int32_t robot, int32_t count, int32_t first_word);
  /* Sensors: requests values that an effect offers; without such an effect the scenario is refused.
   * Returns the place of the first in SkybodyLanes::offered. */
  int32_t (*offered)(void* host, const char* name, int32_t robot, int32_t count);
} SkybodyDeclare;

/* Checked mode, for groups of one lane: the number of values that a call may access, and the first
 * access out of range. Such an access is redirected to `nothing`, so that memory is not corrupted.
 */
typedef struct SkybodyChecks {
  int32_t bodies, q, u, rotors, params, sensors, action, command, robots;
  int32_t bodies_before, contacts; /* bodies; 0 if the plugin did not request them */
  int32_t contact_pairs,
      joint_reactions;           /* those of all plugins; 0 if the plugin did not request them */
  int32_t buffer, scratch, memo; /* of the called plugin */
  int32_t input, output, info;   /* of this call; `output` also stands for the observation */
  int32_t offered;               /* those of all plugins; 0 if the plugin did not request them */
  const char* what; /* array of the first access out of range, such as "output"; NULL: none */
  int32_t index, size;
  double nothing;
} SkybodyChecks;

/* Inputs of every step function. Pointers are per group; strides are `lanes`. */
typedef struct SkybodyLanes {
  uint32_t lanes;          /* L: 1 or SKYBODY_GROUP_LANES */
  uint32_t active;         /* bit l: serve lane l */
  const uint64_t* key;     /* 2: seed, stream env */
  const uint64_t* episode; /* 1 */
  const uint64_t* step; /* 1: actions taken in this episode; the current one is counted in evaluate
                           and goal, but not in process, control and sense */
  const uint64_t* physics_step; /* 1: physics steps completed in this episode */
  const double* bodies;         /* 13 per body: p (W), q (w x y z), v (W), w (B) */
  const double* bodies_before;  /* the same at the start of the last physics step, or NULL */
  const double* q;
  const double* u;
  const double* rotor_speed; /* 1 per rotor [rad/s] */
  const double*
      rotor_command;      /* 1 per rotor [rad/s]: last output of the controllers, not yet limited */
  const double* params;   /* EnvParams */
  const double* sensors;  /* outputs of all sensors */
  const double* action;   /* clipped action row of this step */
  const double* command;  /* commands of all chains */
  const double* contacts; /* 7 per body, or NULL: force and moment about the body's origin of all
                             contacts (W) [N, N m], then 1 if the body is in contact, else 0 */
  const double* contact_pairs;   /* 7 per pair that plugins request, as in `contacts`, or NULL */
  const double* joint_reactions; /* 6 per joint that plugins request, or NULL: force and moment
                                    about the body's origin (W) [N, N m] */
  double* scratch;               /* of this call, see SkybodyDeclare::scratch */
  double* memo;                  /* of this plugin, see SkybodyDeclare::memo */
  unsigned char* images;  /* in sense: the images of this sensor in lane 0, in the order of their
                             declaration, each at a multiple of 8 bytes; otherwise NULL */
  uint64_t image_stride;  /* bytes between the images of neighbouring lanes */
  uint64_t steps_to_read; /* in sense: physics steps after this one before the images of this sensor
                             are read, 0: they are read next; SKYBODY_NEVER_READ: no reader;
                             SKYBODY_DRAW_AGAIN: the state was restored, and its images, which are
                             not part of it, are to be drawn again; nothing else may change */
  SkybodyChecks* checks;  /* NULL: not checked */
  const double* plugin_words; /* words of all plugins, or NULL */
  const int32_t* offered;     /* 1 per value requested by offered(): its row in plugin_words */
} SkybodyLanes;

/* Reason for a call of a randomizer. */
typedef enum SkybodyOccasion {
  SKYBODY_AT_RESET = 0,
  SKYBODY_ON_REQUEST = 1, /* a caller requests a draw now, whatever the randomizer's own schedule */
  SKYBODY_IN_TIME = 2     /* before a physics step, if it has declared draws_in_time */
} SkybodyOccasion;

/* State that a randomizer may change at a reset. */
typedef struct SkybodyStart {
  double* q;
  double* u;
  double* rotor_speed;
  double* params;
  uint32_t occasion; /* SkybodyOccasion; outside of a reset only parameters may be written */
} SkybodyStart;

/* Inputs that an effect adds to; NULL if it does not hold that input. Neutral at the call. */
typedef struct SkybodyHeld {
  double* input[SKYBODY_HELD_COUNT];
} SkybodyHeld;

/* Results of a task after a step. `end` bits: 1 terminated, 2 truncated. Lanes that are not active
 * may be written, except for `end`. */
typedef struct SkybodyEvaluation {
  double* observation;
  double* reward;       /* 1: of the environment or the team */
  uint64_t* end;        /* 1 */
  double* robot_reward; /* 1 per robot of the world; read if the task declared robot_rewards */
  double* info;         /* values as declared by info */
  uint32_t wants_info;  /* 0: nothing reads info, which may be left unwritten */
} SkybodyEvaluation;

/* Number type of a step function: doubles, or dual numbers (core/base/math/dual.h), which carry a
 * derivative. */
enum SkybodyNumber { SKYBODY_NUMBER_REAL = 0, SKYBODY_NUMBER_DUAL = 1, SKYBODY_NUMBER_COUNT = 2 };

/* The functions of one instruction set. Functions of other kinds are NULL; optional ones may be. */
typedef struct SkybodyKernels {
  /* any kind, optional: initial state at a reset (without it all words are 0) */
  void (*reset)(const void* self, const SkybodyLanes* lanes, uint64_t* state, double* buffer);
  void (*control)(const void* self, const SkybodyLanes* lanes, uint64_t* state, double* buffer,
                  const double* input, double* output);
  void (*sense)(const void* self, const SkybodyLanes* lanes, uint64_t* state, double* buffer,
                double* output);
  /* randomizers; tasks: optional, called at a reset after the robots are placed and before reset(),
   * to draw parameters that the task declared by `writes` */
  void (*randomize)(const void* self, const SkybodyLanes* lanes, uint64_t* state, double* buffer,
                    const SkybodyStart* start);
  /* tasks, optional: without it the host scales the action to the first controllers' ranges */
  void (*process)(const void* self, const SkybodyLanes* lanes, uint64_t* state, double* buffer,
                  const double* action, double* command);
  void (*apply)(const void* self, const SkybodyLanes* lanes, uint64_t* state, double* buffer,
                const SkybodyHeld* held);
  void (*evaluate)(const void* self, const SkybodyLanes* lanes, uint64_t* state, double* buffer,
                   const SkybodyEvaluation* out);
  /* tasks: optional; 4 values per declared goal: position (W) [m], yaw [rad] */
  void (*goal)(const void* self, const SkybodyLanes* lanes, const uint64_t* state,
               const double* buffer, double* goal);
  /* tasks: optional; motion of the goals, 6 values each: velocity (W) [m/s], acceleration [m/s^2]
   */
  void (*goal_motion)(const void* self, const SkybodyLanes* lanes, const uint64_t* state,
                      const double* buffer, double* motion);
} SkybodyKernels;

typedef struct SkybodyPlugin {
  uint32_t kind; /* SkybodyKind */
  uint32_t state_words;
  const char* name;
  const char* version;
  const char* doc; /* one line */
  const SkybodyParameter* parameters;
  uint32_t parameter_count;
  uint32_t vectorized; /* 1: kernels serve several lanes at once; 0: one lane after the other */
  /* Creates an instance. On failure returns NULL and writes a message to `error`. Never throws. */
  void* (*create)(const SkybodySetup* setup, const SkybodyDeclare* declare, char* error,
                  size_t error_size);
  void (*destroy)(void* self);
  /* By SkybodyNumber and SkybodyIsa. Dual numbers: reset, control, apply, process and evaluate of
   * plugins that declare themselves smooth; all others are NULL. */
  SkybodyKernels kernels[SKYBODY_NUMBER_COUNT][SKYBODY_ISA_COUNT];
} SkybodyPlugin;

/* The exported object. */
typedef struct SkybodyPluginLibrary {
  uint64_t magic;
  uint32_t abi_version;
  uint32_t library_size; /* sizeof of each structure in the author's compiler */
  uint32_t plugin_size;
  uint32_t kernels_size;
  uint32_t setup_size;
  uint32_t declare_size;
  uint32_t lanes_size;
  uint32_t parameter_size;
  uint64_t structures; /* hash of the sizes of all structures of this file, see structures.h */
  uint64_t (*fp_probe)(void);
  const SkybodyPlugin* const* plugins;
  uint32_t plugin_count;
  const char* failure; /* reason why the plugin could not describe itself, or NULL */
} SkybodyPluginLibrary;

#ifdef __cplusplus
}
#endif

#endif /* SKYBODY_PLUGIN_ABI_ABI_H */
