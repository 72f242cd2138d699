#include "core/physics/contact/manifold.h"

#include "core/base/simd/kernel_width.h"
#include "core/physics/contact/collide.h"

namespace skybody {
namespace {

struct Meet {
  template <int W>
  static SKYBODY_INLINE void run(const void* call) {
    using Real = RealOf<W>;
    const auto& c = *static_cast<const CollideCall<Real>*>(call);
    add_places(c.model_a, c.a, c.model_b, c.b, c.is_close, c.out);
  }
};

}  // namespace

CollideFunction* collide_function(int lanes) { return width_function<Meet>(lanes); }

}  // namespace skybody
