// The box of positions that actions -1 to +1 span: parameters `position_min` and `position_max`.
#pragma once

#include "controllers/common/robot.h"

namespace skybody::control {

/// Declared as a member of the controller `owner`.
class PositionBox {
 public:
  explicit PositionBox(Plugin* owner, const char* low_doc = "position for action -1 (W)",
                       const char* high_doc = "position for action +1 (W)")
      : low_(owner, reals("position_min", "m", {-5.0, -5.0, 0.5}, kAny, low_doc)),
        high_(owner, reals("position_max", "m", {5.0, 5.0, 3.0}, kAny, high_doc)) {}

  /// @throws std::runtime_error if the minimum is not below the maximum
  void configure() const { require_order("position_min", low(), "position_max", high()); }

  Vec3<double> low() const { return low_.vec3(); }    ///< W [m]
  Vec3<double> high() const { return high_.vec3(); }  ///< W [m]

  /// Declares a position and a heading as the controller's input.
  void declare_position(const Setup& setup) const {
    const Vec3<double> a = low(), b = high();
    setup.input(Signal::kPosition, {a.x, a.y, a.z, -kPi}, {b.x, b.y, b.z, kPi});
  }
  /// Declares a pose as the controller's input.
  void declare_pose(const Setup& setup) const { declare_pose(setup, low(), high()); }
  static void declare_pose(const Setup& setup, const Vec3<double>& low, const Vec3<double>& high) {
    setup.input(Signal::kPose, {low.x, low.y, low.z, -1.0, -1.0, -1.0, -1.0},
                {high.x, high.y, high.z, 1.0, 1.0, 1.0, 1.0});
  }

  /// The nearest position of the box.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> clamped(const Vec3<Real>& p) const {
    const Vec3<double> a = low(), b = high();
    return {clamp(p.x, Real(a.x), Real(b.x)), clamp(p.y, Real(a.y), Real(b.y)),
            clamp(p.z, Real(a.z), Real(b.z))};
  }

 private:
  RealsParameter low_, high_;
};

}  // namespace skybody::control
