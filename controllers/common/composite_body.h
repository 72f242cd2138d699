// Composite body: a robot with its joints at their initial coordinates, as one rigid body. Places
// of its bodies, mass, centre of mass and inertia, from nominal constants, in the base's frame.
#pragma once

#include <vector>

#include "controllers/common/driven_joint.h"

namespace skybody::control {

/// Pose of a frame in another one.
struct Placed {
  Vec3<double> position{0.0, 0.0, 0.0};
  Quat<double> rotation{1.0, 0.0, 0.0, 0.0};

  Vec3<double> point(const Vec3<double>& p) const { return position + rotate(rotation, p); }
  Placed then(const Placed& b) const { return {point(b.position), rotation * b.rotation}; }
  Placed inverse() const { return {-rotate_inverse(rotation, position), conjugate(rotation)}; }
};

inline Placed placed(const double (&pose)[7]) { return {position_of(pose), rotation_of(pose)}; }

/// Pose of a body in its parent for the inboard joint's `coordinate`. Joints with no or several
/// coordinates are at rest.
inline Placed placed_in_parent(const BodyInfo& body, double coordinate) {
  Placed moved;
  if (body.joint == SKYBODY_PIN) {
    moved.rotation = from_axis_angle(Vec3<double>{0.0, 0.0, 1.0}, coordinate);
  }
  if (body.joint == SKYBODY_SLIDER) moved.position.x = coordinate;
  return placed(body.joint_in_parent).then(moved).then(placed(body.joint_in_body).inverse());
}

struct CompositeBody {
  std::vector<Placed> bodies;  ///< poses of the robot's bodies in their order, base first
  double mass = 0.0;           ///< [kg]
  Vec3<double> com{0.0, 0.0, 0.0};
  SymMat3<double> inertia{};  ///< about com [kg m^2]
};

/// Adds a body's inertia, moved and rotated. @param arm  from com to the body's centre of mass
inline void add_inertia(SymMat3<double>& sum, double mass, const Vec3<double>& arm,
                        const Quat<double>& turn, const SymMat3<double>& inertia) {
  const auto column = [&](const Vec3<double>& e) {
    return rotate(turn, inertia * rotate_inverse(turn, e)) + mass * cross(arm, cross(e, arm));
  };
  const Vec3<double> x = column({1.0, 0.0, 0.0}), y = column({0.0, 1.0, 0.0}),
                     z = column({0.0, 0.0, 1.0});
  sum = {sum.xx + x.x, sum.yy + y.y, sum.zz + z.z, sum.xy + x.y, sum.xz + x.z, sum.yz + y.z};
}

inline CompositeBody assembly_of(const Setup& setup, int robot) {
  const RobotInfo& r = setup.robots()[robot];
  CompositeBody all;
  for (int i = r.first_body; i < r.first_body + r.body_count; ++i) {
    const BodyInfo& body = setup.bodies()[i];
    Placed here;
    if (i > r.first_body) {
      const Placed& parent = all.bodies[static_cast<std::size_t>(body.parent - r.first_body)];
      here = parent.then(placed_in_parent(body, body.joint_start));
    }
    all.bodies.push_back(here);
    all.mass += body.mass;
    all.com += here.point(vec3(body.com)) * body.mass;
  }
  all.com = all.com / all.mass;
  for (int i = r.first_body; i < r.first_body + r.body_count; ++i) {
    const BodyInfo& body = setup.bodies()[i];
    const Placed& here = all.bodies[static_cast<std::size_t>(i - r.first_body)];
    add_inertia(all.inertia, body.mass, here.point(vec3(body.com)) - all.com, here.rotation,
                inertia_of(body));
  }
  return all;
}

}  // namespace skybody::control
