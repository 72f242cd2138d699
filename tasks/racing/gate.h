// A gate: an opening in a frame of four bars.
#pragma once

#include <skybody/plugin.h>

namespace skybody::racing {

/// Pose and size of a gate. Its frame: x in the passing direction, y to the left, z up.
template <class Real>
struct Gate {
  Vec3<Real> centre;    ///< centre of the opening, W [m]
  Quat<Real> rotation;  ///< W from its frame
  Vec3<Real> half;      ///< half of the frame's depth (x), of the opening's width and height [m]

  /// A point of W in the gate's frame [m]; x is the signed distance from its plane, negative before
  /// it.
  SKYBODY_INLINE Vec3<Real> local(const Vec3<Real>& p) const {
    return rotate_inverse(rotation, p - centre);
  }
  /// The passing direction, W.
  SKYBODY_INLINE Vec3<Real> normal() const {
    return rotate(rotation, Vec3<Real>{Real(1.0), Real(0.0), Real(0.0)});
  }
  /// Whether a point of the gate's plane is in the opening.
  SKYBODY_INLINE MaskOf<Real> opens_at(const Vec3<Real>& in_frame) const {
    return logical_and(abs(in_frame.y) <= half.y, abs(in_frame.z) <= half.z);
  }
};

/// `a` where the mask holds, else `b`.
template <class Real>
SKYBODY_INLINE Gate<Real> choose(const MaskOf<Real>& mask, const Gate<Real>& a,
                                 const Gate<Real>& b) {
  return {select(mask, a.centre, b.centre), select(mask, a.rotation, b.rotation),
          select(mask, a.half, b.half)};
}

/// Whether the bounding boxes of two frames intersect: separating-axis test over six faces and nine
/// pairs of edges (S. Gottschalk, M. Lin, D. Manocha, "OBBTree", 1996, section 5).
inline bool overlap(const Gate<double>& a, const Gate<double>& b) {
  const auto outer = [](const Gate<double>& g, int k) {
    const double bar = 2.0 * g.half.x;
    return k == 0 ? g.half.x : (k == 1 ? g.half.y : g.half.z) + bar;
  };
  const auto axis = [](const Gate<double>& g, int k) {
    return rotate(g.rotation,
                  Vec3<double>{k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0});
  };
  const auto separates = [&](const Vec3<double>& along) {
    if (norm(along) < 1e-9) return false;  // parallel edges: covered by the faces
    double reach = 0.0;
    for (int k = 0; k < 3; ++k) {
      reach += abs(dot(axis(a, k), along)) * outer(a, k);
      reach += abs(dot(axis(b, k), along)) * outer(b, k);
    }
    return abs(dot(b.centre - a.centre, along)) > reach;
  };
  for (int i = 0; i < 3; ++i) {
    if (separates(axis(a, i)) || separates(axis(b, i))) return false;
    for (int k = 0; k < 3; ++k) {
      if (separates(cross(axis(a, i), axis(b, k)))) return false;
    }
  }
  return true;
}

}  // namespace skybody::racing
