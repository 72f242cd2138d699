// Whether anything that could touch is near: the choice between tree dynamics and Simbody, whose
// contact is needed only there (group_stepper.cpp). On double and packs.
//
// Each body's collision shapes lie in one bounding sphere, obstacles in oriented boxes. A sphere is
// widened by the way that its centre can go in one physics step, so that no stage of an integrator
// meets a contact that the step's start has not seen:
//   way <= dt (|v_x| + |v_y| + |v_z|) + kMargin,  v the centre's velocity at the start.
// The sum is no less than |v| and needs no root. kMargin is what acceleration may add to it,
// a dt^2 / 2: 2000 m/s^2 at 1 ms. Semi-implicit Euler asks for forces at the start only and needs
// neither. Where bodies accelerate harder (impacts, pose drives that jump) a Runge-Kutta stage may
// miss the first bit of a contact, and the next step has it.
#pragma once

#include <cstddef>
#include <vector>

#include "core/physics/bodies/kinematics.h"
#include "core/physics/world/world.h"

namespace skybody {

/// Where a body's collision shapes are during one physics step.
template <class Real>
struct SweptSphere {
  Vec3<Real> center;  ///< at the step's start, W [m]
  Real radius;        ///< [m]
};

/// Bounding volumes of a world. Immutable. Meshes of files are ignored, as Simbody's contact
/// ignores them; bodies of one robot do not touch each other.
class Reach {
 public:
  explicit Reach(const World& world);

  /// False where nothing can ever touch: one robot without obstacles, robots without shapes.
  bool is_possible() const { return is_possible_; }
  /// Bodies with collision shapes.
  std::size_t sphere_count() const { return spheres_.size(); }

  /// Whether a body may touch a body of another robot or an obstacle in the step that begins; in
  /// the lanes of a pack each for itself. A motion that is not finite is within reach of nothing.
  /// @param motion  of all bodies
  /// @param swept   work space for sphere_count() spheres
  template <class Real>
  SKYBODY_INLINE MaskOf<Real> is_within(const BodyKinematics<Real>* motion,
                                        SweptSphere<Real>* swept) const {
    sweep(motion, swept);
    MaskOf<Real> within = robots_meet(swept);
    for (const Box& box : boxes_) within |= meets(box, swept);
    return within;
  }

 private:
  /// Bounds the collision shapes of one body.
  struct Sphere {
    int body = 0;                        ///< world body index
    std::size_t next_robot = 0;          ///< the first sphere of a later robot
    Vec3<double> center{0.0, 0.0, 0.0};  ///< in the body's frame [m]
    double radius = 0.0;                 ///< with kMargin [m]
  };
  /// Bounds an obstacle: everything within `rounding` of a box.
  struct Box {
    Vec3<double> center{0.0, 0.0, 0.0};  ///< W [m]
    Vec3<double> axis[3];                ///< unit, W
    Vec3<double> half{0.0, 0.0, 0.0};    ///< half edge lengths along the axes [m]
    double rounding = 0.0;               ///< [m]
  };

  void add_spheres(const World& world);
  void add_boxes(const World& world);

  template <class Real>
  SKYBODY_INLINE void sweep(const BodyKinematics<Real>* motion, SweptSphere<Real>* swept) const {
    for (std::size_t i = 0; i < spheres_.size(); ++i) {
      const Sphere& sphere = spheres_[i];
      const BodyKinematics<Real>& body = motion[sphere.body];
      const Vec3<Real> arm = body.axes * to_real<Real>(sphere.center);
      const Vec3<Real> v = body.velocity + cross(body.angular_velocity, arm);
      swept[i] = {body.position + arm,
                  Real(sphere.radius) + dt_ * ((abs(v.x) + abs(v.y)) + abs(v.z))};
    }
  }

  template <class Real>
  SKYBODY_INLINE MaskOf<Real> robots_meet(const SweptSphere<Real>* swept) const {
    MaskOf<Real> within(false);
    for (std::size_t i = 0; i < spheres_.size(); ++i) {
      for (std::size_t j = spheres_[i].next_robot; j < spheres_.size(); ++j) {
        const Vec3<Real> apart = swept[i].center - swept[j].center;
        const Real reach = swept[i].radius + swept[j].radius;
        within |= dot(apart, apart) < reach * reach;
      }
    }
    return within;
  }

  template <class Real>
  SKYBODY_INLINE MaskOf<Real> meets(const Box& box, const SweptSphere<Real>* swept) const {
    const Vec3<Real> center = to_real<Real>(box.center);
    const Vec3<Real> x = to_real<Real>(box.axis[0]);
    const Vec3<Real> y = to_real<Real>(box.axis[1]);
    const Vec3<Real> z = to_real<Real>(box.axis[2]);
    MaskOf<Real> within(false);
    for (std::size_t i = 0; i < spheres_.size(); ++i) {
      const Vec3<Real> from_center = swept[i].center - center;
      const Vec3<Real> outside{beyond(dot(x, from_center), box.half.x),
                               beyond(dot(y, from_center), box.half.y),
                               beyond(dot(z, from_center), box.half.z)};
      const Real reach = swept[i].radius + box.rounding;
      within |= dot(outside, outside) < reach * reach;
    }
    return within;
  }

  /// How far a coordinate lies beyond an edge; NaN stays NaN.
  template <class Real>
  static SKYBODY_INLINE Real beyond(const Real& x, double half) {
    const Real over = abs(x) - half;
    return select(over < Real(0.0), Real(0.0), over);
  }

  double dt_ = 0.0;
  bool is_possible_ = false;
  std::vector<Sphere> spheres_;  ///< in the order of robots
  std::vector<Box> boxes_;
};

}  // namespace skybody
