#include "core/physics/bodies/contact_spheres.h"

#include <algorithm>
#include <vector>

#include "core/base/math.h"
#include "core/physics/bodies/kinematics.h"
#include "core/physics/world/world.h"

namespace skybody {
namespace {

constexpr int kRimPoints = 8;
/// Spheres within this height of the lowest one carry the robot at rest [m].
constexpr double kLevel = 1e-3;
/// Of a body's mass, what an impact on one of its extremities feels: the rest gives way by turning.
constexpr double kEffectiveShare = 0.25;
/// Largest stiffness of a light body's spheres: (frequency x dt)^2 of the body on one sphere.
/// Semi-implicit Euler is stable up to 4 of the value with the effective mass.
constexpr double kLargestSquaredPhase = 0.25;

/// Extremities of one shape, in the body's frame.
std::vector<ContactSphere> extremities(const Shape& shape) {
  std::vector<ContactSphere> out;
  const auto add = [&](double x, double y, double z, double radius) {
    const Vec3<double> center = shape.pose.position + rotate(shape.pose.rotation, {x, y, z});
    out.push_back({0, center, radius, 0.0});
  };
  switch (shape.type) {
    case ShapeType::kBox:
      for (int corner = 0; corner < 8; ++corner) {
        const auto half = [corner](int bit, double edge) {
          return (corner >> bit & 1) != 0 ? 0.5 * edge : -0.5 * edge;
        };
        add(half(0, shape.size.x), half(1, shape.size.y), half(2, shape.size.z), 0.0);
      }
      break;
    case ShapeType::kCylinder:
      for (int end = 0; end < 2; ++end) {
        for (int i = 0; i < kRimPoints; ++i) {
          const SinCos<double> angle = sincos(i * (kTwoPi / kRimPoints));
          const double z = end == 0 ? -0.5 * shape.length : 0.5 * shape.length;
          add(shape.radius * angle.cos, shape.radius * angle.sin, z, 0.0);
        }
      }
      break;
    case ShapeType::kSphere:
      add(0.0, 0.0, 0.0, shape.radius);
      break;
    case ShapeType::kMesh:
      break;
  }
  return out;
}

/// Motion of all bodies with joints at zero and every free base at the origin, upright.
std::vector<BodyKinematics<double>> upright_bodies(const World& world) {
  std::vector<double> q(64 + 7 * world.bodies.size(), 0.0), u(q.size(), 0.0);
  for (const WorldBody& body : world.bodies) {
    if (body.model->joint.type == JointType::kBall) q[body.q] = 1.0;
    if (body.model->joint.type == JointType::kFree) q[body.q + 3] = 1.0;
  }
  std::vector<BodyKinematics<double>> bodies(world.bodies.size());
  forward_kinematics(make_tree(world), q.data(), u.data(), bodies.data());
  return bodies;
}

/// Number of spheres of one robot that lie within kLevel of its lowest.
int count_lowest(const World& world, const std::vector<ContactSphere>& spheres, int robot,
                 const std::vector<BodyKinematics<double>>& bodies) {
  const auto height = [&](const ContactSphere& s) {
    return (bodies[s.body].position + bodies[s.body].axes * s.center).z - s.radius;
  };
  double lowest = kInfinity;
  for (const ContactSphere& s : spheres) {
    if (world.bodies[s.body].robot == robot) lowest = min(lowest, height(s));
  }
  int count = 0;
  for (const ContactSphere& s : spheres) {
    count += world.bodies[s.body].robot == robot && height(s) <= lowest + kLevel;
  }
  return count;
}

void set_stiffness(const World& world, std::vector<ContactSphere>& spheres) {
  const std::vector<BodyKinematics<double>> bodies = upright_bodies(world);
  const Scenario& scenario = world.scenario;
  const double g = contact_gravity(scenario);
  const double depth = scenario.contact.penetration;
  for (std::size_t robot = 0; robot < scenario.robots.size(); ++robot) {
    const int carriers = std::max(1, count_lowest(world, spheres, static_cast<int>(robot), bodies));
    const double carried = scenario.robots[robot].model.total_mass() / carriers;
    const double wanted = carried * g / pow_3_2(depth);
    for (ContactSphere& s : spheres) {
      if (world.bodies[s.body].robot != static_cast<int>(robot)) continue;
      if (is_error_controlled(scenario.stepping.integrator)) {  // no step is too large
        s.stiffness = wanted;
        s.most_damping = kInfinity;
        continue;
      }
      // Around the static penetration the spring is 1.5 k sqrt(x0).
      const double mass = world.bodies[s.body].model->mass.mass;
      const double dt = scenario.stepping.dt;
      const double most = kLargestSquaredPhase * mass / (dt * dt) / (1.5 * sqrt(depth));
      s.stiffness = min(wanted, most);
      s.most_damping = min(carried, kEffectiveShare * mass) / dt;
    }
  }
}

}  // namespace

double contact_gravity(const Scenario& scenario) {
  const double g = norm(scenario.gravity());
  return g > 0.0 ? g : 9.81;
}

std::vector<ContactSphere> make_contact_spheres(const World& world) {
  std::vector<ContactSphere> spheres;
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    for (const Shape& shape : world.bodies[i].model->collisions) {
      for (ContactSphere sphere : extremities(shape)) {
        sphere.body = static_cast<int>(i);
        spheres.push_back(sphere);
      }
    }
  }
  set_stiffness(world, spheres);
  return spheres;
}

}  // namespace skybody
