#include "core/env/plugin_setup_tables.h"

#include <algorithm>
#include <array>

#include "core/physics/bodies/default_state.h"

namespace skybody {
namespace {

/// Whether an enumerator of ours has the same number as its counterpart in the plugin API.
template <class Ours>
constexpr bool is_number(Ours ours, int theirs) {
  return static_cast<int>(ours) == theirs;
}

static_assert(is_number(JointType::kWeld, SKYBODY_WELD));
static_assert(is_number(JointType::kFree, SKYBODY_FREE));
static_assert(is_number(JointType::kPin, SKYBODY_PIN));
static_assert(is_number(JointType::kSlider, SKYBODY_SLIDER));
static_assert(is_number(JointType::kUniversal, SKYBODY_UNIVERSAL));
static_assert(is_number(JointType::kBall, SKYBODY_BALL));

static_assert(is_number(ColumnType::kFloat32, SKYBODY_FLOAT32));
static_assert(is_number(ColumnType::kUint8, SKYBODY_UINT8));
static_assert(is_number(ColumnType::kUint16, SKYBODY_UINT16));

static_assert(is_number(JointMode::kPosition, SKYBODY_JOINT_POSITION));
static_assert(is_number(JointMode::kVelocity, SKYBODY_JOINT_VELOCITY));
static_assert(is_number(JointMode::kEffort, SKYBODY_JOINT_EFFORT));

void copy(const Vec3<double>& v, double* out) {
  out[0] = v.x;
  out[1] = v.y;
  out[2] = v.z;
}

void copy(const Quat<double>& q, double* out) {
  out[0] = q.w;
  out[1] = q.x;
  out[2] = q.y;
  out[3] = q.z;
}

void copy(const Pose& pose, double* out) {
  copy(pose.position, out);
  copy(pose.rotation, out + 3);
}

SkybodyBodyInfo body_info(const Topology& topology, const StateLayout& layout, int index) {
  const WorldBody& b = topology.bodies[static_cast<std::size_t>(index)];
  const MassProperties& m = b.model->mass;
  SkybodyBodyInfo info{};
  info.name = b.model->name.c_str();
  info.robot = b.robot;
  info.parent = b.parent;
  info.mass = m.mass;
  copy(m.com, info.com);
  const std::array<double, kBodyParamCount> constants = body_constants(m);
  std::copy(constants.begin() + kInertia, constants.end(), info.inertia);
  info.first_param = layout.body_params[static_cast<std::size_t>(index)];
  info.first_joint_param = layout.joint_params[static_cast<std::size_t>(index)];
  info.joint_param_count = joint_constant_count(b.model->joint);
  info.first_q = b.q;
  info.first_u = b.u;
  info.joint = static_cast<int>(b.model->joint.type);
  info.joint_name = b.model->joint.name.c_str();
  info.joint_is_limited = b.model->joint.limit.enabled ? 1 : 0;
  info.joint_lower = b.model->joint.limit.lower;
  info.joint_upper = b.model->joint.limit.upper;
  info.joint_start = b.model->joint.position;
  copy(b.model->joint.frame_in_parent, info.joint_in_parent);
  copy(b.model->joint.frame_in_body, info.joint_in_body);
  return info;
}

SkybodyRotorInfo rotor_info(const Topology& topology, const StateLayout& layout, int index) {
  const WorldRotor& w = topology.rotors[static_cast<std::size_t>(index)];
  const Rotor& r = *w.model;
  SkybodyRotorInfo info{};
  info.name = r.name.c_str();
  info.robot = w.robot;
  info.body = w.body;
  copy(r.position(), info.position);
  copy(r.axis, info.axis);
  const auto robot = static_cast<std::size_t>(w.robot);
  const Pose place = place_at_reset(topology.scenario.robots[robot].model, r.body);
  copy(place.position + rotate(place.rotation, r.position()), info.position_in_base);
  copy(rotate(place.rotation, r.axis), info.axis_in_base);
  info.direction = r.direction;
  info.min_speed = r.min_speed;
  std::copy(r.constants.begin(), r.constants.end(), info.constants);
  info.first_param = layout.rotor_params[static_cast<std::size_t>(index)];
  return info;
}

SkybodyRobotInfo robot_info(const Topology& topology, const StateLayout& layout, int index) {
  const RobotUse& use = topology.scenario.robots[static_cast<std::size_t>(index)];
  const RobotLayout& robot = layout.robots[static_cast<std::size_t>(index)];
  SkybodyRobotInfo info{};
  info.name = use.name.c_str();
  info.first_body = robot.first_body;
  info.body_count = robot.body_count;
  info.first_rotor = robot.first_rotor;
  info.rotor_count = robot.rotor_count;
  info.first_q = robot.first_q;
  info.q_count = robot.q_count;
  info.first_u = robot.first_u;
  info.u_count = robot.u_count;
  info.first_param = layout.robot_params[static_cast<std::size_t>(index)];
  info.fixed_base = use.model.fixed_base ? 1 : 0;
  copy(use.pose.position, info.position);
  copy(use.pose.rotation, info.rotation);
  return info;
}

/// A shape without an owner.
SkybodyShapeInfo shape_info(const Shape& shape, const std::string& name) {
  SkybodyShapeInfo info{};
  info.name = name.c_str();
  info.mesh = shape.mesh.c_str();
  info.robot = info.body = info.obstacle = info.first_param = -1;
  switch (shape.type) {
    case ShapeType::kBox:
      info.kind = SKYBODY_BOX;
      copy(shape.size, info.size);
      break;
    case ShapeType::kCylinder:
      info.kind = SKYBODY_CYLINDER;
      copy(Vec3<double>{shape.radius, shape.length, 0.0}, info.size);
      break;
    case ShapeType::kSphere:
      info.kind = SKYBODY_SPHERE;
      copy(Vec3<double>{shape.radius, 0.0, 0.0}, info.size);
      break;
    case ShapeType::kCapsule:
      info.kind = SKYBODY_CAPSULE;
      copy(Vec3<double>{shape.radius, shape.length, 0.0}, info.size);
      break;
    case ShapeType::kPlane:
      info.kind = SKYBODY_PLANE;
      break;
    case ShapeType::kHeightField:
      info.kind = SKYBODY_HEIGHT_FIELD;
      copy(Vec3<double>{shape.size.x, shape.size.y, shape.heights->highest()}, info.size);
      break;
    case ShapeType::kMesh:
      info.kind = SKYBODY_MESH;
      copy(shape.size, info.size);
      break;
  }
  copy(shape.pose.position, info.position);
  copy(shape.pose.rotation, info.rotation);
  return info;
}

PluginInstance& instance_of(void* host) { return *static_cast<PluginInstance*>(host); }

Channel to_channel(const SkybodyChannel& c) {
  Channel channel{c.name, c.unit, c.count, c.low, c.high, c.robot, c.privileged != 0};
  channel.type = static_cast<ColumnType>(c.type);
  channel.shape.assign(c.shape, c.shape + std::clamp(c.rank, 0, 3));
  channel.doc = c.doc;
  return channel;
}

/// Calls of controllers.
void declare_commands(SkybodyDeclare& d) {
  d.input = [](void* host, int32_t signal, int32_t count, const double* low, const double* high) {
    PluginInstance& p = instance_of(host);
    p.controller.input_signal = signal;
    ++p.controller.input_calls;
    p.controller.passes_on = count > 0 && (low == nullptr || high == nullptr);
    p.controller.low.assign(static_cast<std::size_t>(std::max(count, 0)), -1.0);
    p.controller.high.assign(p.controller.low.size(), 1.0);
    if (p.controller.passes_on) return;  // until the chain is known
    p.controller.low.assign(low, low + count);
    p.controller.high.assign(high, high + count);
  };
  d.output = [](void* host, int32_t robot, int32_t signal, int32_t count) {
    instance_of(host).controller.outputs.push_back({robot, signal, count});
  };
  d.site = [](void* host, const SkybodySite* site) {
    instance_of(host).controller.sites.push_back({site->body,
                                                  {site->point[0], site->point[1], site->point[2]},
                                                  site->at_com != 0,
                                                  site->world_axes != 0});
  };
  d.joint = [](void* host, const SkybodyJointDrive* j) {
    instance_of(host).controller.joints.push_back(
        {j->body, j->coordinate, static_cast<JointMode>(j->mode), j->stiffness, j->damping,
         j->effort_limit, j->tau, j->low, j->high});
  };
}

/// Calls of effects, sensors and randomizers.
void declare_effects(SkybodyDeclare& d) {
  d.holds = [](void* host, int32_t input) {
    if (input < 0 || input >= SKYBODY_HELD_COUNT) return;
    instance_of(host).effect.holds[static_cast<std::size_t>(input)] = true;
  };
  d.steady = [](void* host) { instance_of(host).effect.is_steady = true; };
  d.only_when_read = [](void* host) { instance_of(host).sensor.is_only_when_read = true; };
  d.writes = [](void* host, int32_t param) { instance_of(host).writes.push_back(param); };
  d.offers = [](void* host, const char* name, int32_t robot, int32_t count, int32_t word) {
    instance_of(host).effect.offers.push_back({name, robot, count, word});
  };
  d.offered = [](void* host, const char* name, int32_t robot, int32_t count) {
    PluginInstance& p = instance_of(host);
    const int place = p.memory.first_offered + p.sensor.requested();
    p.sensor.requests.push_back({name, robot, count});
    return static_cast<int32_t>(place);
  };
  d.draws_in_time = [](void* host) { instance_of(host).randomizer.draws_in_time = true; };
}

/// Calls of tasks.
void declare_task(SkybodyDeclare& d) {
  d.action = [](void* host, const SkybodyChannel* c) {
    instance_of(host).task.actions.push_back(to_channel(*c));
  };
  d.interpolate = [](void* host) { instance_of(host).task.interpolates = true; };
  d.goal = [](void* host, int32_t robot, int32_t body, const double* point) {
    instance_of(host).task.goals.push_back({robot, body, {point[0], point[1], point[2]}});
  };
  d.robot_rewards = [](void* host) { instance_of(host).task.robot_rewards = true; };
  d.info = [](void* host, const SkybodyChannel* c) {
    instance_of(host).task.infos.push_back(to_channel(*c));
  };
  d.repeat = [](void* host, int32_t to, int32_t from, int32_t count) {
    instance_of(host).task.repeats.push_back({from, to, count});
  };
}

/// Calls of every kind.
void declare_common(SkybodyDeclare& d) {
  d.channel = [](void* host, const SkybodyChannel* c) {
    instance_of(host).channels.push_back(to_channel(*c));
  };
  d.period = [](void* host, int32_t steps) { instance_of(host).period = std::max(1, steps); };
  d.scratch = [](void* host, int32_t values) { instance_of(host).memory.scratch = values; };
  d.scratch_block = [](void* host, int32_t values) {
    instance_of(host).memory.scratch_block = values;
  };
  d.memo = [](void* host, int32_t values) { instance_of(host).memory.memo = values; };
  d.report = [](void* host, const SkybodyChannel* c, int32_t word) {
    instance_of(host).reports.push_back({to_channel(*c), word});
  };
  d.contacts = [](void* host) { instance_of(host).needs_contacts = true; };
  d.contact_pair = [](void* host, int32_t body, int32_t partner, int32_t other) {
    PluginInstance& p = instance_of(host);
    p.contact_pairs.push_back({body, static_cast<SkybodyPartner>(partner), other});
    return p.memory.first_contact_pair + static_cast<int32_t>(p.contact_pairs.size()) - 1;
  };
  d.joint_reaction = [](void* host, int32_t body) {
    PluginInstance& p = instance_of(host);
    p.joint_reactions.push_back(body);
    return p.memory.first_joint_reaction + static_cast<int32_t>(p.joint_reactions.size()) - 1;
  };
  d.buffer = [](void* host, int32_t words) { instance_of(host).memory.buffer_words = words; };
  d.bodies_before = [](void* host) { instance_of(host).needs_bodies_before = true; };
  d.reads = [](void* host, int32_t first) { instance_of(host).reads.push_back(first); };
}

}  // namespace

BoundValues::BoundValues(const std::vector<ParameterValue>& values) {
  texts_.reserve(values.size());
  for (const ParameterValue& value : values) {
    std::vector<const char*>& texts = texts_.emplace_back();
    for (const std::string& text : value.texts) texts.push_back(text.c_str());
    const bool is_text = value.type == ParameterType::kText;
    table_.push_back({value.numbers.data(), texts.data(),
                      static_cast<std::uint32_t>(is_text ? texts.size() : value.numbers.size()), -1,
                      value.is_given ? 1u : 0u});
  }
}

SetupTables::SetupTables(const Topology& topology, const StateLayout& layout)
    : scenario_(topology.scenario), layout_(layout), pictures_(topology.scenario.read_picture) {
  for (int i = 0; i < static_cast<int>(scenario_.robots.size()); ++i) {
    robots_.push_back(robot_info(topology, layout, i));
    const int first_body = layout.robots[static_cast<std::size_t>(i)].first_body;
    for (const Link& link : scenario_.robots[static_cast<std::size_t>(i)].model.links) {
      SkybodyLinkInfo info{};
      info.name = link.name.c_str();
      info.robot = i;
      info.body = first_body + link.body;
      copy(link.pose.position, info.position);
      copy(link.pose.rotation, info.rotation);
      copy(link.com, info.com);
      links_.push_back(info);
    }
  }
  for (int i = 0; i < static_cast<int>(topology.bodies.size()); ++i) {
    bodies_.push_back(body_info(topology, layout, i));
  }
  for (int i = 0; i < static_cast<int>(topology.rotors.size()); ++i) {
    rotors_.push_back(rotor_info(topology, layout, i));
  }
  add_shapes(topology);
  add_visuals(topology);
  for (const EnvParam& p : layout.param_info) {
    params_.push_back({p.path.c_str(), p.alias.c_str(), p.nominal, p.min, p.max});
  }
}

void SetupTables::add_shapes(const Topology& topology) {
  for (int i = 0; i < static_cast<int>(topology.bodies.size()); ++i) {
    const WorldBody& body = topology.bodies[static_cast<std::size_t>(i)];
    for (const Shape& shape : body.model->collisions) {
      shapes_.push_back(shape_info(shape, body.model->name));
      shapes_.back().robot = body.robot;
      shapes_.back().body = i;
    }
  }
  for (int i = 0; i < static_cast<int>(scenario_.obstacles.size()); ++i) {
    const Obstacle& obstacle = scenario_.obstacles[static_cast<std::size_t>(i)];
    shapes_.push_back(shape_info(obstacle.shape, obstacle.name));
    shapes_.back().obstacle = i;
    shapes_.back().first_param = layout_.obstacle_params[static_cast<std::size_t>(i)];
    if (obstacle.is_gate) shapes_.back().kind = SKYBODY_GATE;
  }
}

/// A body with a mesh of a format that is not read is drawn by its collision shapes, in the colour
/// of its first visual.
void SetupTables::add_visuals(const Topology& topology) {
  const auto is_unreadable = [](const Shape& shape) {
    return shape.type == ShapeType::kMesh && !shape.read_triangles;
  };
  for (int i = 0; i < static_cast<int>(topology.bodies.size()); ++i) {
    const Body& body = *topology.bodies[static_cast<std::size_t>(i)].model;
    const bool is_drawn = !body.visuals.empty() &&
                          std::none_of(body.visuals.begin(), body.visuals.end(), is_unreadable);
    for (const Shape& shape : is_drawn ? body.visuals : body.collisions) {
      SkybodyVisualInfo& info = visuals_.emplace_back();
      const Shape drawn = is_drawn ? shape : contact_shape(shape);
      info.shape = shape_info(drawn, body.name);
      info.shape.mesh = shape.mesh.c_str();
      visual_shapes_.push_back(&shape);
      info.shape.robot = topology.bodies[static_cast<std::size_t>(i)].robot;
      info.shape.body = i;
      const Shape& painted = is_drawn || body.visuals.empty() ? shape : body.visuals.front();
      std::copy(painted.rgba.begin(), painted.rgba.end(), info.color);
      info.texture = is_drawn ? shape.texture_file.c_str() : "";
    }
  }
}

SkybodySetup SetupTables::setup(const std::string& instance, const std::vector<int>& team,
                                const std::vector<SkybodyValue>& values) const {
  SkybodySetup s{};
  s.instance = instance.c_str();
  s.dt = scenario_.stepping.dt;
  s.action_repeat = scenario_.stepping.action_repeat;
  s.horizon = scenario_.stepping.horizon;
  copy(scenario_.gravity(), s.gravity);
  s.first_world_param = layout_.world_params;
  s.team = team.data();
  s.team_size = static_cast<int>(team.size());
  s.robots = robots_.data();
  s.robot_count = static_cast<int>(robots_.size());
  s.bodies = bodies_.data();
  s.body_count = static_cast<int>(bodies_.size());
  s.links = links_.data();
  s.link_count = static_cast<int>(links_.size());
  s.rotors = rotors_.data();
  s.rotor_count = static_cast<int>(rotors_.size());
  s.sensors = sensors_.data();
  s.sensor_count = static_cast<int>(sensors_.size());
  s.chains = chains_.data();
  s.chain_count = static_cast<int>(chains_.size());
  s.shapes = shapes_.data();
  s.shape_count = static_cast<int>(shapes_.size());
  s.visuals = visuals_.data();
  s.visual_count = static_cast<int>(visuals_.size());
  s.tables = const_cast<SetupTables*>(this);
  s.visual_triangles = [](void* tables, int32_t visual) {
    const auto& own = *static_cast<const SetupTables*>(tables);
    return own.meshes_.of_file(*own.visual_shapes_[static_cast<std::size_t>(visual)]);
  };
  s.obstacle_triangles = [](void* tables, int32_t obstacle) {
    const auto& own = *static_cast<const SetupTables*>(tables);
    return own.meshes_.of_field(own.scenario_.obstacles[static_cast<std::size_t>(obstacle)].shape);
  };
  s.picture = [](void* tables, const char* file) {
    return static_cast<const SetupTables*>(tables)->pictures_.of_file(file);
  };
  s.params = params_.data();
  s.param_count = static_cast<int>(params_.size());
  s.values = values.data();
  s.value_count = static_cast<int>(values.size());
  return s;
}

void SetupTables::add_sensor(const PluginInstance& sensor) {
  int first = sensor.sensor.output;
  for (const Channel& channel : sensor.channels) {
    if (channel.is_image()) continue;
    names_.push_back(std::make_unique<std::string>(sensor.name));
    const char* instance = names_.back()->c_str();
    names_.push_back(std::make_unique<std::string>(channel.name));
    sensors_.push_back({instance, names_.back()->c_str(), first, channel.count});
    first += channel.count;
  }
}

void SetupTables::set_chains(const std::vector<ControllerChain>& chains) {
  for (const ControllerChain& chain : chains) {
    if (chain.is_fed) continue;
    SkybodyRobotInfo& robot = robots_[static_cast<std::size_t>(chain.robot)];
    if (robot.chain_count++ == 0) {
      robot.first_chain = static_cast<int>(chains_.size());
      robot.first_action = chain.command;
    }
    robot.action_count += chain.inputs;
    chains_.push_back({chain.robot, chain.signal, chain.command, chain.inputs});
  }
}

SkybodyDeclare declare_into(PluginInstance& instance) {
  SkybodyDeclare d{};
  d.host = &instance;
  declare_commands(d);
  declare_effects(d);
  declare_task(d);
  declare_common(d);
  return d;
}

}  // namespace skybody
