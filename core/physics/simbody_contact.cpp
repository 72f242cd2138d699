#include "core/physics/simbody_contact.h"

#include <algorithm>
#include <cmath>

namespace skybody {
namespace {

/// Radius of curvature at which spheres and meshes are equally stiff [m]; also the thickness of the
/// elastic layer on meshes.
constexpr double kReferenceRadius = 0.05;
/// Faces of a mesh are springs: they have to be small beside what touches them [m].
constexpr double kBodyFace = 0.02, kObstacleFace = 0.03;
/// Bounds on the cost of a mesh: vertices added along the longest edge.
constexpr int kBodyResolution = 10, kObstacleResolution = 60;

/// Hertz stiffness at which two spheres of one material and effective radius kReferenceRadius hold
/// the heaviest robot's weight with the scenario's static penetration:
///   F = 4/3 sqrt(R) (E/2^1.5) x^1.5 (CompliantContactSubsystem, HertzCircular).
SimTK::ContactMaterial make_material(const World& world) {
  double mass = 0.0;
  for (const RobotUse& robot : world.scenario.robots) {
    mass = std::max(mass, robot.model.total_mass());
  }
  const ContactSettings& contact = world.scenario.contact;
  const double depth = contact.penetration;
  const double stiffness = mass * 9.81 * std::sqrt(8.0) * 0.75 /
                           (std::sqrt(kReferenceRadius) * depth * std::sqrt(depth));
  return {stiffness, contact.dissipation, contact.friction, contact.friction, 0.0};
}

int resolution_of(double longest_edge, double largest_face, int most) {
  return std::clamp(static_cast<int>(std::ceil(longest_edge / largest_face)) - 1, 0, most);
}

}  // namespace

bool has_body_contact(const World& world) {
  return !world.scenario.obstacles.empty() || world.scenario.robots.size() > 1;
}

SimbodyContact::SimbodyContact(const World& world)
    : transition_velocity_(world.scenario.contact.slip_velocity) {
  const SimTK::ContactMaterial material = make_material(world);
  for (const Obstacle& obstacle : world.scenario.obstacles) {
    add(-1, obstacle.shape, material, {}, kObstacleFace, kObstacleResolution);
  }
  std::vector<SimTK::ContactCliqueId> cliques;
  for (std::size_t r = 0; r < world.scenario.robots.size(); ++r) {
    cliques.push_back(SimTK::ContactSurface::createNewContactClique());
  }
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    const WorldBody& body = world.bodies[i];
    for (const Shape& shape : body.model->collisions) {
      add(static_cast<int>(i), shape, material, cliques[body.robot], kBodyFace, kBodyResolution);
    }
  }
}

void SimbodyContact::add(int body, const Shape& shape, const SimTK::ContactMaterial& material,
                         SimTK::ContactCliqueId clique, double largest_face,
                         int largest_resolution) {
  const auto add_geometry = [&](const SimTK::ContactGeometry& geometry) {
    SimTK::ContactSurface surface(geometry, material, kReferenceRadius);
    if (clique.isValid()) surface.joinClique(clique);
    surfaces_.push_back({body, to_simbody(shape.pose), surface});
  };
  if (shape.type == ShapeType::kSphere) {
    add_geometry(SimTK::ContactGeometry::Sphere(shape.radius));
  } else if (shape.type == ShapeType::kBox) {
    const SimTK::Vec3 half(0.5 * shape.size.x, 0.5 * shape.size.y, 0.5 * shape.size.z);
    const int n = resolution_of(2.0 * SimTK::max(half), largest_face, largest_resolution);
    add_geometry(
        SimTK::ContactGeometry::TriangleMesh(SimTK::PolygonalMesh::createBrickMesh(half, n)));
  } else if (shape.type == ShapeType::kCylinder) {
    // The base's polygon has 6 (n + 1) edges.
    const double rim = 2.0 * shape.radius;
    const int n = std::min(resolution_of(rim, largest_face, largest_resolution), 8);
    add_geometry(SimTK::ContactGeometry::TriangleMesh(SimTK::PolygonalMesh::createCylinderMesh(
        SimTK::ZAxis, shape.radius, 0.5 * shape.length, n)));
  }
}

void SimbodyContact::add_surfaces(int body, SimTK::Body& rigid) const {
  for (const Surface& s : surfaces_) {
    if (s.body == body) rigid.addContactSurface(s.pose, s.surface);
  }
}

SimTK::Rotation to_simbody(const Quat<double>& q) {
  return SimTK::Rotation(SimTK::Quaternion(q.w, q.x, q.y, q.z));
}

SimTK::Transform to_simbody(const Pose& pose) {
  return {to_simbody(pose.rotation),
          SimTK::Vec3(pose.position.x, pose.position.y, pose.position.z)};
}

}  // namespace skybody
