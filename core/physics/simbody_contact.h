// Collision shapes of bodies and obstacles as Simbody's compliant contact has them. Only files of
// skybody_simbody include this. C++17.
#pragma once

#include <Simbody.h>

#include <memory>
#include <vector>

#include "core/physics/world.h"

namespace skybody {

/// The contact surfaces of a world, made once; systems are built from them again and again, by
/// several threads at a time: nothing here changes after construction, and Simbody's
/// ContactGeometry (unlike its PolygonalMesh) has no reference count; every system gets a deep
/// copy. Shapes of one size share theirs here. More shapes and faces than fit into some 500 MB are
/// an Error.
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
    SimTK::Transform pose;
    std::shared_ptr<const SimTK::ContactGeometry> geometry;
    double thickness = 0.0;         ///< of the elastic layer [m]
    SimTK::ContactCliqueId clique;  ///< surfaces of one do not collide
  };
  void add_obstacles(const World& world);
  void add_bodies(const World& world);

  SimTK::ContactMaterial material_;
  std::vector<Surface> surfaces_;
  double transition_velocity_ = 0.0;
};

/// Simbody's rotation and transform of ours.
SimTK::Rotation to_simbody(const Quat<double>& q);
SimTK::Transform to_simbody(const Pose& pose);

}  // namespace skybody
