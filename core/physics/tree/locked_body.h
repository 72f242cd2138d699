// A robot as one rigid body: all joints locked at their present positions. On double, packs and
// dual numbers.
#pragma once

#include <vector>

#include "core/base/math/dual.h"
#include "core/physics/bodies/body_constants.h"

namespace skybody {

template <class Real>
struct LockedBody {
  SymMat3<Real> inertia;  ///< about the centre of mass, base axes [kg m^2]
  Vec3<Real> com;         ///< from the base's origin, base axes [m]

  /// Torque-free rates that the body's own spin causes (docs/dynamics.md, Fast spins).
  /// @param axes  of the base, W
  /// @param velocity  written: rate of the origin's velocity, W
  /// @returns the rate of the spin
  SKYBODY_INLINE Vec3<Real> spin_rates(const Mat3<Real>& axes, const Vec3<Real>& spin,
                                       Vec3<Real>& velocity) const {
    const Vec3<Real> rate = -(inverse(inertia) * cross(spin, inertia * spin));
    velocity = -(axes * (cross(rate, com) + cross(spin, cross(spin, com))));
    return rate;
  }

  /// a where the mask is set, else b.
  friend SKYBODY_INLINE LockedBody select(const MaskOf<Real>& mask, const LockedBody& a,
                                          const LockedBody& b) {
    const SymMat3<Real>&i = a.inertia, &j = b.inertia;
    return {{select(mask, i.xx, j.xx), select(mask, i.yy, j.yy), select(mask, i.zz, j.zz),
             select(mask, i.xy, j.xy), select(mask, i.xz, j.xz), select(mask, i.yz, j.yz)},
            select(mask, a.com, b.com)};
  }
};

/// Computes the LockedBody of one robot. Refers to its arguments.
template <class Real>
struct LockedBodyCall {
  const std::vector<TreeBody>& tree;
  int first, last;               ///< its bodies: [first, last)
  const Real* constants;         ///< kBodyConstantCount per body of the world
  const Real *q, *u;             ///< of the whole world
  BodyKinematics<Real>* motion;  ///< per body of the world; this robot's entries are overwritten
  LockedBody<Real>& out;

  SKYBODY_INLINE void run() const {
    forward_kinematics(tree, first, last, q, u, motion);
    Real mass(0.0);
    Vec3<Real> moment{Real(0.0), Real(0.0), Real(0.0)};
#pragma GCC unroll 1
    for (int i = first; i < last; ++i) {
      mass += constants_of(i)[kBodyMass];
      moment += com_of(i) * constants_of(i)[kBodyMass];
    }
    const Vec3<Real> com = moment * (1.0 / mass);
    const Real none(0.0);
    SymMat3<Real> inertia{none, none, none, none, none, none};
#pragma GCC unroll 1
    for (int i = first; i < last; ++i) {
      const SymMat3<Real> own =
          rotate_inertia(motion[i].axes, load_sym_mat3(constants_of(i) + kBodyInertia));
      inertia = inertia + (own + point_inertia(constants_of(i)[kBodyMass], com_of(i) - com));
    }
    const Mat3<Real>& axes = motion[first].axes;
    out.com = transpose_times(axes, com - motion[first].position);
    out.inertia = rotate_inertia(transpose(axes), inertia);
  }

 private:
  const Real* constants_of(int i) const { return constants + kBodyConstantCount * i; }
  SKYBODY_INLINE Vec3<Real> com_of(int i) const {
    return motion[i].position + motion[i].axes * load_vec3(constants_of(i) + kBodyCom);
  }
};

/// Runs a call with the number type of the width.
using LockedBodyFunction = void(const void* call);

/// @param lanes  1: doubles; otherwise packs
LockedBodyFunction* locked_body_function(int lanes);

template <class Real>
SKYBODY_INLINE LockedBody<Real> lock(const std::vector<TreeBody>& tree, int first, int last,
                                     const Real* constants, const Real* q, const Real* u,
                                     BodyKinematics<Real>* motion) {
  const Real* base = constants + kBodyConstantCount * first;
  LockedBody<Real> out{load_sym_mat3(base + kBodyInertia), load_vec3(base + kBodyCom)};
  if (last - first == 1) return out;
  const LockedBodyCall<Real> call{tree, first, last, constants, q, u, motion, out};
  if constexpr (kIsDual<Real>) {
    call.run();
  } else {
    locked_body_function(kLanesOf<Real>)(&call);
  }
  return out;
}

}  // namespace skybody
