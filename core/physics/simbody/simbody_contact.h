// Collision shapes of bodies and obstacles as Simbody's compliant contact has them. Only files of
// skybody_simbody include this. C++17.
#pragma once

#include <Simbody.h>

#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "core/physics/world/world.h"

namespace skybody {

/// How finely a box or cylinder becomes triangles.
struct MeshFineness {
  double largest_face;  ///< wanted edge of its faces [m]
  int most_vertices;    ///< at most so many are added along the longest edge
};

/// The contact surfaces of a world; systems are built from them again and again, by several threads
/// at a time. Simbody's ContactGeometry (unlike its PolygonalMesh) has no reference count; every
/// system gets a deep copy. The search tree of a large box's mesh takes a second to build and
/// hardly any time to copy: a geometry is made when a system first needs it, once for each size.
///
/// Spheres are exact (Hertz); boxes and cylinders are triangle meshes (elastic foundation). Meshes
/// of files are ignored. Bodies of one robot do not collide among themselves. Simbody's trackers
/// for these shapes keep no history, so the forces are a function of q and u alone.
class SimbodyContact {
 public:
  explicit SimbodyContact(const World& world);

  /// Surfaces of one body of the world; body -1: of the obstacles.
  void add_surfaces(int body, SimTK::Body& rigid) const;

  /// Friction's transition velocity [m/s].
  double transition_velocity() const { return transition_velocity_; }

 private:
  struct Surface {
    int body = -1;
    Shape shape;
    MeshFineness fineness;
    double thickness = 0.0;         ///< of the elastic layer [m]
    SimTK::ContactCliqueId clique;  ///< surfaces of one do not collide
  };
  using Key = std::array<double, 7>;  ///< of a shape's numbers and its fineness
  void add_obstacles(const World& world);
  void add_bodies(const World& world);
  std::shared_ptr<const SimTK::ContactGeometry> geometry_of(const Surface& surface) const;

  SimTK::ContactMaterial material_;
  std::vector<Surface> surfaces_;
  double transition_velocity_ = 0.0;
  mutable std::mutex mutex_;  ///< guards geometries_
  mutable std::map<Key, std::shared_ptr<const SimTK::ContactGeometry>> geometries_;
};

/// Simbody's rotation and transform of ours.
SimTK::Rotation to_simbody(const Quat<double>& q);
SimTK::Transform to_simbody(const Pose& pose);

}  // namespace skybody
