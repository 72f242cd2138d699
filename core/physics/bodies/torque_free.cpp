#include "core/physics/bodies/torque_free.h"

#include "core/base/simd/kernel_width.h"

namespace skybody {
namespace {

struct MoveFreely {
  template <int W>
  static SKYBODY_INLINE void run(const void* call) {
    static_cast<const TorqueFreeCall<RealOf<W>>*>(call)->run();
  }
};

}  // namespace

TorqueFreeFunction* torque_free_function(int lanes) { return width_function<MoveFreely>(lanes); }

}  // namespace skybody
