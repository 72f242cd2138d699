#include "core/physics/simbody/simbody_contact.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "core/base/error.h"
#include "core/physics/bodies/contact_spheres.h"

namespace skybody {
namespace {

/// Radius of curvature at which spheres and meshes are about equally stiff [m]; also the least
/// thickness of the elastic layer on meshes.
constexpr double kReferenceRadius = 0.05;
/// Faces of a mesh are springs: they have to be small beside what touches them. Vertices are added
/// along the longest edge at the cost of time.
constexpr MeshFineness kBodyMesh{0.02, 10}, kObstacleMesh{0.03, 60};
/// Bound on a cylinder's faces: Simbody takes some 2 s to build the search tree of so many.
constexpr double kMostFaces = 100'000;

/// Hertz stiffness at which two spheres of one material and effective radius kReferenceRadius hold
/// the heaviest robot's weight with the scenario's static penetration:
///   F = 4/3 sqrt(R) (E/2^1.5) x^1.5 (CompliantContactSubsystem, HertzCircular).
SimTK::ContactMaterial make_material(const World& world) {
  const Scenario& scenario = world.scenario;
  double mass = 0.0;
  for (const RobotUse& robot : scenario.robots) mass = std::max(mass, robot.model.total_mass());
  const double depth = scenario.contact.penetration;
  const double stiffness = mass * contact_gravity(scenario) * std::sqrt(8.0) * 0.75 /
                           (std::sqrt(kReferenceRadius) * depth * std::sqrt(depth));
  const double friction = scenario.constants[kFriction];
  return {stiffness, scenario.constants[kDissipation], friction, friction, 0.0};
}

int resolution_of(double longest_edge, const MeshFineness& fineness) {
  return std::clamp(static_cast<int>(std::ceil(longest_edge / fineness.largest_face)) - 1, 0,
                    fineness.most_vertices);
}

/// Faces of a cylinder's side: rings of 6 (n + 1) quads as long as they are wide, two faces each.
double cylinder_faces(const Shape& shape, int n) {
  return 12.0 * (n + 1) * (n + 1) * shape.length / shape.radius;
}

/// Long and thin ones get fewer and longer faces.
int cylinder_resolution(const Shape& shape, const MeshFineness& fineness) {
  int n = std::min(resolution_of(2.0 * shape.radius, fineness), 8);
  while (n > 0 && cylinder_faces(shape, n) > kMostFaces) --n;
  return n;
}

/// @param whose  for the message, such as "the obstacle `pole`"
void check_shape(const Shape& shape, const std::string& whose) {
  if (shape.type != ShapeType::kCylinder || cylinder_faces(shape, 0) <= kMostFaces) return;
  char text[160];
  std::snprintf(text, sizeof text,
                "%.6g times as long as its radius; allowed where bodies may touch: at most %.0f; "
                "write a shorter one, or a box",
                shape.length / shape.radius, kMostFaces / 12.0);
  throw Error("the cylinder of " + whose + " is " + text);
}

SimTK::ContactGeometry make_geometry(const Shape& shape, const MeshFineness& fineness) {
  if (shape.type == ShapeType::kSphere) return SimTK::ContactGeometry::Sphere(shape.radius);
  if (shape.type == ShapeType::kBox) {
    const SimTK::Vec3 half(0.5 * shape.size.x, 0.5 * shape.size.y, 0.5 * shape.size.z);
    const int n = resolution_of(2.0 * SimTK::max(half), fineness);
    return SimTK::ContactGeometry::TriangleMesh(SimTK::PolygonalMesh::createBrickMesh(half, n));
  }
  const int n = cylinder_resolution(shape, fineness);
  return SimTK::ContactGeometry::TriangleMesh(
      SimTK::PolygonalMesh::createCylinderMesh(SimTK::ZAxis, shape.radius, 0.5 * shape.length, n));
}

/// The largest area with which a shape can lie flat on another [m^2].
double largest_area(const Shape& shape) {
  const Vec3<double>& s = shape.size;
  switch (shape.type) {
    case ShapeType::kBox:
      return std::max({s.x * s.y, s.x * s.z, s.y * s.z});
    case ShapeType::kCylinder:
      return std::max(SimTK::Pi * shape.radius, 2.0 * shape.length) * shape.radius;
    case ShapeType::kSphere:
      return SimTK::Pi * shape.radius * shape.radius;
    case ShapeType::kMesh:
      return 0.0;
  }
  return 0.0;
}

/// Thickness of the elastic layer: an elastic foundation is a spring of E A / thickness. Lying flat
/// it must not be so stiff that dt cannot follow: E A / thickness <= kSquaredPhase m / dt^2.
double layer_thickness(const Shape& shape, double stiffness, double mass, double dt) {
  constexpr double kSquaredPhase = 0.05;
  return std::max(kReferenceRadius,
                  stiffness * largest_area(shape) * dt * dt / (kSquaredPhase * mass));
}

}  // namespace

std::shared_ptr<const SimbodyContact> make_simbody_contact(const World& world) {
  // Bodies of different robots, or bodies and obstacles.
  if (world.scenario.obstacles.empty() && world.scenario.robots.size() < 2) return nullptr;
  return std::make_shared<const SimbodyContact>(world);
}

SimbodyContact::SimbodyContact(const World& world)
    : material_(make_material(world)),
      transition_velocity_(world.scenario.constants[kSlipVelocity]) {
  add_obstacles(world);
  add_bodies(world);
}

void SimbodyContact::add_obstacles(const World& world) {
  for (const Obstacle& obstacle : world.scenario.obstacles) {
    const Shape& shape = obstacle.shape;
    if (shape.type == ShapeType::kMesh) continue;
    check_shape(shape, "the obstacle `" + obstacle.name + "`");
    // In series with the layer of whatever touches it, which is the softer one.
    surfaces_.push_back({-1, shape, kObstacleMesh, kReferenceRadius, {}});
  }
}

void SimbodyContact::add_bodies(const World& world) {
  std::vector<SimTK::ContactCliqueId> cliques;
  for (std::size_t r = 0; r < world.scenario.robots.size(); ++r) {
    cliques.push_back(SimTK::ContactSurface::createNewContactClique());
  }
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    const WorldBody& body = world.bodies[i];
    for (const Shape& shape : body.model->collisions) {
      if (shape.type == ShapeType::kMesh) continue;
      check_shape(shape, "the body `" + body.model->name + "`");
      const double thickness = layer_thickness(shape, material_.getStiffness(),
                                               body.model->mass.mass, world.scenario.stepping.dt);
      surfaces_.push_back({static_cast<int>(i), shape, kBodyMesh, thickness, cliques[body.robot]});
    }
  }
}

std::shared_ptr<const SimTK::ContactGeometry> SimbodyContact::geometry_of(
    const Surface& surface) const {
  const Shape& shape = surface.shape;
  const Key key{static_cast<double>(shape.type),
                shape.size.x,
                shape.size.y,
                shape.size.z,
                shape.radius,
                shape.length,
                surface.fineness.largest_face};
  const std::lock_guard<std::mutex> lock(mutex_);
  auto& made = geometries_[key];
  if (made == nullptr) {
    made = std::make_shared<const SimTK::ContactGeometry>(make_geometry(shape, surface.fineness));
  }
  return made;
}

void SimbodyContact::add_surfaces(int body, SimTK::Body& rigid) const {
  for (const Surface& s : surfaces_) {
    if (s.body != body) continue;
    SimTK::ContactSurface surface(*geometry_of(s), material_, s.thickness);
    if (s.clique.isValid()) surface.joinClique(s.clique);
    rigid.addContactSurface(to_simbody(s.shape.pose), surface);
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
