#include "core/physics/shapes/height_field.h"

#include "core/base/simd/kernel_width.h"
#include "core/physics/shapes/height_field_distance.h"

namespace skybody {
namespace {

struct FindDistance {
  template <int W>
  static SKYBODY_INLINE void run(void* call) {
    using Real = RealOf<W>;
    auto& c = *static_cast<HeightFieldCall<Real>*>(call);
    const HeightGrid<Real> grid(c.field, c.half_x, c.half_y);
    c.out = height_field_distance(grid, c.reach, c.point);
  }
};

}  // namespace

HeightFieldFunction* height_field_function(int lanes) {
  return width_function<FindDistance>(lanes);
}

}  // namespace skybody
