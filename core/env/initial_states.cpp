#include "core/env/initial_states.h"

#include <algorithm>

#include "core/base/math/quat.h"
#include "core/base/simd/lane_mask.h"
#include "core/physics/bodies/default_state.h"
#include "core/physics/world/world_layout.h"

namespace skybody {
namespace {

bool is_floating(const WorldBody& body) {
  return body.parent < 0 && body.model->joint.type == JointType::kFree;
}

/// Number of a joint position's values that can be drawn one by one: 0 for a ball joint (its
/// position is a quaternion) and for a floating link.
int drawn_position_size(JointType type) {
  const bool has =
      type == JointType::kPin || type == JointType::kSlider || type == JointType::kUniversal;
  return has ? position_size(type) : 0;
}

}  // namespace

/// Fills the EnvParams and places.
struct InitialStates::Author {
  const Topology& world;
  StateLayout& layout;
  std::vector<Place>& places;

  /// Appends EnvParams `path` or `path[0]`, ... @returns the first
  int add(const std::string& path, const std::string& alias, const char* unit,
          const std::vector<double>& nominal, double low = -kInfinity, double high = kInfinity) {
    const int first = static_cast<int>(layout.param_info.size());
    for (std::size_t k = 0; k < nominal.size(); ++k) {
      const std::string index = nominal.size() == 1 ? "" : "[" + std::to_string(k) + "]";
      add_param(layout, {path + index, unit, nominal[k], min(low, nominal[k]),
                         max(high, nominal[k]), alias.empty() ? "" : alias + index});
    }
    return first;
  }

  void add_base(const std::string& path, const WorldBody& body, const Pose& pose) {
    const Vec3<double>& p = pose.position;
    const Quat<double>& q = pose.rotation;
    const std::vector<double> none(3, 0.0);
    places.push_back(
        {&StateLayout::q, body.q, add(path + "position", "", "m", {p.x, p.y, p.z}), 3});
    const int rotation = add(path + "rotation", "", "", {q.w, q.x, q.y, q.z}, -1.0, 1.0);
    const int turn = add(path + "turn", "", "rad", none);
    places.push_back({&StateLayout::q, body.q + 3, rotation, 4, turn});
    places.push_back({&StateLayout::u, body.u, add(path + "velocity", "", "m/s", none), 3});
    places.push_back(
        {&StateLayout::u, body.u + 3, add(path + "angular_velocity", "", "rad/s", none), 3});
  }

  void add_rotors(const std::string& path, const RobotLayout& robot) {
    for (int k = 0; k < robot.rotor_count; ++k) {
      const int i = robot.first_rotor + k;
      const Rotor& rotor = *world.rotors[static_cast<std::size_t>(i)].model;
      const int param = add(path + "rotors[" + std::to_string(k) + "].speed",
                            path + "rotors." + rotor.name + ".speed", "rad/s",
                            {start_rotor_speed(world, i)}, rotor.min_speed);
      const int limit = layout.rotor_params[static_cast<std::size_t>(i)] + kMaxSpeed;
      places.push_back({&StateLayout::rotor_speed, i, param, 1, -1, limit});
    }
  }

  /// @param number  among the robot's moving joints
  void add_joint(const std::string& path, const WorldBody& body, int number) {
    const Joint& joint = body.model->joint;
    const bool is_travel = joint.type == JointType::kSlider;
    const std::string own = path + "joints." + joint.name + ".";
    const std::string alias = path + "joints[" + std::to_string(number) + "].";
    if (const int n = drawn_position_size(joint.type); n > 0) {
      const double low = joint.limit.enabled ? joint.limit.lower : -kInfinity;
      const double high = joint.limit.enabled ? joint.limit.upper : kInfinity;
      const std::vector<double> nominal(static_cast<std::size_t>(n), n == 1 ? joint.position : 0.0);
      places.push_back(
          {&StateLayout::q, body.q,
           add(own + "position", alias + "position", is_travel ? "m" : "rad", nominal, low, high),
           n});
    }
    if (joint.type == JointType::kFree) return;
    const int n = velocity_size(joint.type);
    places.push_back({&StateLayout::u, body.u,
                      add(own + "velocity", alias + "velocity", is_travel ? "m/s" : "rad/s",
                          std::vector<double>(static_cast<std::size_t>(n), 0.0)),
                      n});
  }

  void add_robot(int r) {
    const RobotUse& use = world.scenario.robots[static_cast<std::size_t>(r)];
    const RobotLayout& robot = layout.robots[static_cast<std::size_t>(r)];
    const std::string path = "robots." + use.name + ".start.";
    int joints = 0;
    for (int b = robot.first_body; b < robot.first_body + robot.body_count; ++b) {
      const WorldBody& body = world.bodies[static_cast<std::size_t>(b)];
      if (is_floating(body)) add_base(path, body, use.pose);
      if (is_moving_joint(body.model->joint)) add_joint(path, body, joints++);
    }
    add_rotors(path, robot);
  }
};

InitialStates::InitialStates(const Topology& topology, StateLayout& layout)
    : first_(static_cast<int>(layout.param_info.size())) {
  Author author{topology, layout, places_};
  const auto robots = static_cast<int>(topology.scenario.robots.size());
  for (int r = 0; r < robots; ++r) author.add_robot(r);
  end_ = static_cast<int>(layout.param_info.size());
}

std::vector<int> InitialStates::places_of(const std::vector<int>& params) const {
  std::vector<int> found;
  const auto is_written = [&](int first, int count) {
    return std::any_of(params.begin(), params.end(),
                       [&](int p) { return first >= 0 && p >= first && p < first + count; });
  };
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Place& p = places_[i];
    if (is_written(p.param, p.count) || is_written(p.turn, 3) || is_written(p.limit, 1)) {
      found.push_back(static_cast<int>(i));
    }
  }
  return found;
}

void InitialStates::place(StateGroup& group, std::uint32_t mask) const {
  for (const Place& p : places_) place(group, mask, group.layout(), p);
}

void InitialStates::place(StateGroup& group, std::uint32_t mask,
                          const std::vector<int>& places) const {
  for (const int i : places) {
    place(group, mask, group.layout(), places_[static_cast<std::size_t>(i)]);
  }
}

void InitialStates::place(StateGroup& group, std::uint32_t mask, const StateLayout& layout,
                          const Place& place) {
  const int width = group.lanes();
  double* to = group.writable({(layout.*place.block).offset + place.first, place.count}, mask);
  const auto param = [&](int p) { return group.reals(layout.params.offset + p); };
  const double* from = param(place.param);
  each_lane(mask, [&](int lane) {
    for (int k = 0; k < place.count; ++k) to[k * width + lane] = from[k * width + lane];
  });
  if (place.limit >= 0) {
    const double* limit = param(place.limit);
    each_lane(mask, [&](int lane) { to[lane] = min(to[lane], limit[lane]); });
  }
  if (place.turn < 0) return;
  const double* turn = param(place.turn);
  each_lane(mask, [&](int lane) {
    const Vec3<double> rpy{turn[lane], turn[width + lane], turn[2 * width + lane]};
    if (rpy.x == 0.0 && rpy.y == 0.0 && rpy.z == 0.0)
      return;  // keep the bits of the scenario's
               // own rotation
    double* q = to + lane;
    const Quat<double> turned =
        from_rpy(rpy.x, rpy.y, rpy.z) * Quat<double>{q[0], q[width], q[2 * width], q[3 * width]};
    q[0] = turned.w;
    q[width] = turned.x;
    q[2 * width] = turned.y;
    q[3 * width] = turned.z;
  });
}

}  // namespace skybody
