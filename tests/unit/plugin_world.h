// A small hand-made world as seen by a plugin's configure(): QDrone2, and additions by tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <string>
#include <vector>

#include "core/plugin_abi/abi.h"

namespace skybody::testing {

/// Tables behind a SkybodySetup. Add robots first, then call setup().
class PluginWorld {
 public:
  double dt = 0.001;
  double gravity = 9.81;
  int horizon = 0;                       ///< steps of an episode; 0: no end
  std::vector<std::int32_t> team = {0};  ///< robots of a controller
  std::vector<SkybodyRobotInfo> robots;
  std::vector<SkybodyBodyInfo> bodies;
  std::vector<SkybodyLinkInfo> links;
  std::vector<SkybodyRotorInfo> rotors;
  std::vector<SkybodyEnvParamInfo> params;
  std::vector<SkybodyShapeInfo> shapes;  ///< of bodies first, then obstacles
  std::vector<SkybodySensorInfo> sensors;
  int q = 0, u = 0, actions = 0, sensor_values = 0;

  /// The world's own EnvParams come first: gravity.
  PluginWorld() {
    for (int k = 0; k < 3; ++k) {
      add_param("gravity[" + std::to_string(k) + "]", k == 2 ? -gravity : 0.0);
    }
  }

  /// QDrone2 (GzDRL's parameters): one rigid body, four rotors on the base.
  int add_quad(const std::string& name, double x = 0.0, double y = 0.0, double z = 1.0) {
    const int index = add_robot(name, x, y, z);
    add_body(index, "base", -1, 1, 1.54, {0.0147209, 0.0169101, 0.029448});
    const double at[4][3] = {{0.1016, 0.127, 0.023},
                             {-0.1016, -0.127, 0.023},
                             {0.1016, -0.127, 0.023},
                             {-0.1016, 0.127, 0.023}};
    const double direction[4] = {-1.0, -1.0, 1.0, 1.0};
    for (int i = 0; i < 4; ++i) add_rotor(index, at[i], direction[i]);
    return index;
  }

  /// A body on a ball joint below the base of the last robot.
  int add_payload(const std::string& name) {
    return add_body(static_cast<int>(robots.size()) - 1, name, robots.back().first_body, 5, 0.205,
                    {9.8e-4, 9.8e-4, 9.8e-4});
  }

  /// A link on a hinge at the last body.
  int add_arm_link(const std::string& name) {
    const int parent = static_cast<int>(bodies.size()) - 1;
    const int body =
        add_body(bodies.back().robot, name, parent, SKYBODY_PIN, 0.1, {1e-4, 1e-4, 1e-5});
    bodies.back().joint_name = keep(name + "_joint");
    return body;
  }

  int add_robot(const std::string& name, double x, double y, double z) {
    const int index = static_cast<int>(robots.size());
    SkybodyRobotInfo r{};
    r.name = keep(name);
    r.first_body = static_cast<int>(bodies.size());
    r.first_rotor = static_cast<int>(rotors.size());
    r.first_q = q;
    r.first_u = u;
    r.position[0] = x;
    r.position[1] = y;
    r.position[2] = z;
    r.rotation[0] = 1.0;
    r.first_param = static_cast<int>(params.size());
    for (int k = 0; k < 6; ++k)
      add_param("robots." + name + ".disturbance[" + std::to_string(k) + "]", 0.0);
    for (const char* key : {"position", "rotation", "turn", "velocity", "angular_velocity"}) {
      const int count = key == std::string("rotation") ? 4 : 3;
      for (int k = 0; k < count; ++k) {
        add_param("robots." + name + ".start." + key + "[" + std::to_string(k) + "]", 0.0);
      }
    }
    r.first_action = actions;
    r.action_count = 4;
    actions += 4;
    robots.push_back(r);
    return index;
  }

  int add_body(int owner, const std::string& name, int parent, int joint, double mass,
               const std::vector<double>& moments) {
    SkybodyBodyInfo b{};
    const std::string path = std::string("robots.") + robots[at(owner)].name + ".links." + name;
    b.name = keep(name);
    b.robot = owner;
    b.parent = parent;
    b.mass = mass;
    for (int k = 0; k < 3; ++k) b.inertia[k] = moments[at(k)];
    b.first_param = add_param(path + ".mass", mass, 1e-9);
    for (int k = 0; k < 3; ++k) add_param(path + ".com[" + std::to_string(k) + "]", 0.0);
    for (int k = 0; k < 6; ++k)
      add_param(path + ".inertia[" + std::to_string(k) + "]", b.inertia[k]);
    b.first_q = q;
    b.first_u = u;
    b.joint = joint;
    b.joint_in_parent[3] = b.joint_in_body[3] = 1.0;
    const bool is_single = joint == SKYBODY_PIN || joint == SKYBODY_SLIDER;
    q += joint == SKYBODY_FREE ? 7 : is_single ? 1 : 4;
    u += joint == SKYBODY_FREE ? 6 : is_single ? 1 : 3;
    ++robots[at(owner)].body_count;
    bodies.push_back(b);
    SkybodyLinkInfo link{};
    link.name = b.name;
    link.robot = owner;
    link.body = static_cast<int>(bodies.size()) - 1;
    link.rotation[0] = 1.0;
    links.push_back(link);
    return link.body;
  }

  void add_rotor(int owner, const double (&position)[3], double direction) {
    SkybodyRotorInfo r{};
    const std::string name = "rotor" + std::to_string(robots[at(owner)].rotor_count);
    const double constants[SKYBODY_ROTOR_CONSTANT_COUNT] = {
        1.9533e-6, 2.8401e-8, 2.0673e-5,   1e-9,        4.92e-6,    2246.0,
        0.0125,    0.025,     position[0], position[1], position[2]};
    r.name = keep(name);
    r.robot = owner;
    r.body = robots[at(owner)].first_body;
    r.axis[2] = 1.0;
    r.direction = direction;
    r.first_param = static_cast<int>(params.size());
    for (int k = 0; k < 3; ++k) r.position[k] = position[k];
    for (int k = 0; k < SKYBODY_ROTOR_CONSTANT_COUNT; ++k) {
      r.constants[k] = constants[k];
      add_param(std::string("robots.") + robots[at(owner)].name + ".rotors[" +
                    std::to_string(robots[at(owner)].rotor_count) + "].constant" +
                    std::to_string(k),
                constants[k]);
    }
    add_param(std::string("robots.") + robots[at(owner)].name + ".start.rotors[" +
                  std::to_string(robots[at(owner)].rotor_count) + "].speed",
              0.0);
    ++robots[at(owner)].rotor_count;
    rotors.push_back(r);
  }

  /// A collision shape of a body, in its frame.
  void add_shape(int body, int kind, const std::vector<double>& size, double z = 0.0) {
    SkybodyShapeInfo shape{};
    shape.name = bodies[at(body)].name;
    shape.mesh = "";
    shape.kind = kind;
    shape.robot = bodies[at(body)].robot;
    shape.body = body;
    shape.obstacle = shape.first_param = -1;
    for (std::size_t k = 0; k < size.size(); ++k) shape.size[k] = size[k];
    shape.position[2] = z;
    shape.rotation[0] = 1.0;
    shapes.push_back(shape);
  }

  /// An obstacle, rotated by `yaw` [rad]. @param size  as defined for its kind [m]
  /// @returns its first EnvParam
  int add_obstacle(int kind, const std::vector<double>& size, const std::vector<double>& position,
                   double yaw = 0.0, const std::string& name = "") {
    SkybodyShapeInfo shape{};
    shape.obstacle = obstacles_++;
    const std::string own = name.empty() ? "solid_" + std::to_string(obstacles_) : name;
    shape.name = keep(own);
    shape.mesh = "";
    shape.kind = kind;
    shape.robot = shape.body = -1;
    shape.first_param = add_param("obstacles." + own + ".present", 1.0);
    const std::vector<double> turn{std::cos(0.5 * yaw), 0.0, 0.0, std::sin(0.5 * yaw)};
    const auto add = [&](const char* what, double* to, const std::vector<double>& from, int count) {
      for (int k = 0; k < count; ++k) {
        to[k] = at(k) < from.size() ? from[at(k)] : 0.0;
        add_param("obstacles." + own + "." + what + "[" + std::to_string(k) + "]", to[k]);
      }
    };
    add("position", shape.position, position, 3);
    add("rotation", shape.rotation, turn, 4);
    add("size", shape.size, size, static_cast<int>(size.size()));
    shapes.push_back(shape);
    return shape.first_param;
  }

  /// A frame about an opening of `width` by `height` [m] with bars of 0.1 m; its x axis, the
  /// direction of passage, points to `yaw` [rad].
  void add_gate(const std::string& name, const std::vector<double>& position, double yaw,
                double width = 1.4, double height = 1.4) {
    add_obstacle(SKYBODY_GATE, {width, height, 0.1}, position, yaw, name);
  }

  /// An output of another sensor. @returns its first value
  int add_sensor(const std::string& instance, const std::string& channel, int count) {
    sensors.push_back({keep(instance), keep(channel), sensor_values, count});
    sensor_values += count;
    return sensors.back().first;
  }

  int add_param(const std::string& path, double nominal, double min = -1e9, double max = 1e9) {
    params.push_back({keep(path), "", nominal, min, max});
    return static_cast<int>(params.size()) - 1;
  }

  const char* keep(const std::string& text) { return texts_.emplace_back(text).c_str(); }

  SkybodySetup setup(const char* instance, const std::vector<SkybodyValue>& values) const {
    place_rotors();
    SkybodySetup s{};
    s.instance = instance;
    s.dt = dt;
    s.action_repeat = 1;
    s.horizon = horizon;
    s.gravity[2] = -gravity;
    s.team = team.data();
    s.team_size = static_cast<int>(team.size());
    s.robots = robots.data();
    s.robot_count = static_cast<int>(robots.size());
    s.bodies = bodies.data();
    s.body_count = static_cast<int>(bodies.size());
    s.links = links.data();
    s.link_count = static_cast<int>(links.size());
    s.rotors = placed_rotors_.data();
    s.rotor_count = static_cast<int>(rotors.size());
    s.sensors = sensors.data();
    s.sensor_count = static_cast<int>(sensors.size());
    s.shapes = shapes.data();
    s.shape_count = static_cast<int>(shapes.size());
    s.params = params.data();
    s.param_count = static_cast<int>(params.size());
    s.values = values.data();
    s.value_count = static_cast<int>(values.size());
    return s;
  }

 private:
  /// Sets positions in the frame of the base for rotors on the base.
  void place_rotors() const {
    placed_rotors_ = rotors;
    for (SkybodyRotorInfo& r : placed_rotors_) {
      if (r.body != robots[at(r.robot)].first_body) continue;
      std::copy(r.position, r.position + 3, r.position_in_base);
      std::copy(r.axis, r.axis + 3, r.axis_in_base);
    }
  }
  mutable std::vector<SkybodyRotorInfo> placed_rotors_;

  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  std::deque<std::string> texts_;
  int obstacles_ = 0;
};

}  // namespace skybody::testing
