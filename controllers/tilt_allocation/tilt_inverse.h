// Static allocation of a wrench to tilting arms, of least norm: M. Kamel, S. Verling, O. Elkhatib,
// C. Sprecher, P. Wulkop, Z. Taylor, R. Siegwart and I. Gilitschenski, The Voliro omniorientational
// hexacopter, IEEE Robotics & Automation Magazine 25(4), 2018, section "Control allocation". The
// wrench is linear in each arm's force along and across its neutral axis, w = A (f_n1, f_s1, f_n2,
// ...), and A has a constant pseudo-inverse A^T (A A^T)^-1.
#pragma once

#include <string>

#include "controllers/common/six_axis_inverse.h"
#include "controllers/tilt_allocation/tilt_arms.h"

namespace skybody {

class TiltInverse {
 public:
  TiltInverse() = default;
  /// @throws std::runtime_error if the arms do not reach all forces and moments
  TiltInverse(const TiltArms& arms, const std::string& robot) {
    for (const TiltArm& arm : arms.all()) {
      inverse_.add(arm.normal, arm.moment(arm.normal));
      inverse_.add(arm.side, arm.moment(arm.side));
    }
    inverse_.invert("the arms of robot `" + robot + "`",
                    "tilt_allocation needs: three arms or more with axes that are not parallel");
  }

  /// Push of arm i along its neutral axis [N]. @param wrench  force [N], moment [N m]
  template <class Real>
  SKYBODY_INLINE Real along(std::size_t i, const Real (&wrench)[6]) const {
    return inverse_.push(2 * i, wrench);
  }
  /// Push of arm i across its neutral axis [N].
  template <class Real>
  SKYBODY_INLINE Real across(std::size_t i, const Real (&wrench)[6]) const {
    return inverse_.push(2 * i + 1, wrench);
  }

 private:
  control::SixAxisInverse inverse_;
};

}  // namespace skybody
