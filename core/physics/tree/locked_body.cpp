#include "core/physics/tree/locked_body.h"

#include "core/base/simd/kernel_width.h"

namespace skybody {
namespace {

struct Lock {
  template <int W>
  static SKYBODY_INLINE void run(const void* call) {
    static_cast<const LockedBodyCall<RealOf<W>>*>(call)->run();
  }
};

}  // namespace

LockedBodyFunction* locked_body_function(int lanes) { return width_function<Lock>(lanes); }

}  // namespace skybody
