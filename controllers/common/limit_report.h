// Info `limited`: 1 if the controller's own limits reduced its command at the last evaluation, else
// 0. `skybody run` and `check` count it.
#pragma once

#include <skybody/plugin.h>

namespace skybody::control {

class LimitReport {
 public:
  /// @param word  index of the value in the controller's buffer
  void configure(const Setup& setup, int word) {
    setup.report("limited", "", 1, word);
    word_ = word;
  }

  template <class Real, class Mask>
  SKYBODY_INLINE void note(const Mask& is_limited, Values<Real> buffer) const {
    buffer.set(word_, select(is_limited, Real(1.0), Real(0.0)));
  }

 private:
  int word_ = 0;
};

/// Whether a limit changed a vector.
template <class Real>
SKYBODY_INLINE MaskOf<Real> differs(const Vec3<Real>& a, const Vec3<Real>& b) {
  return logical_or(logical_or(a.x != b.x, a.y != b.y), a.z != b.z);
}

}  // namespace skybody::control
