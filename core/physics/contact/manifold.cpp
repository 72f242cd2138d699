#include "core/physics/contact/manifold.h"

#include "core/base/kernels.h"
#include "core/physics/contact/meet.h"

namespace skybody {
namespace {

/// A pack of W lanes; of one: a double.
template <int W>
struct Width {
  using Real = Pack<W>;
};
template <>
struct Width<1> {
  using Real = double;
};

struct Meet {
  template <int W>
  static SKYBODY_INLINE void run(const void* call) {
    using Real = typename Width<W>::Real;
    const auto& c = *static_cast<const MeetCall<Real>*>(call);
    add_places(c.model_a, c.a, c.model_b, c.b, c.is_close, c.out);
  }
};

constexpr int kWidths[] = {
#define SKYBODY_ROW(NAME, LANES, TARGET) LANES,
    SKYBODY_ISAS(SKYBODY_ROW)
#undef SKYBODY_ROW
};

}  // namespace

MeetFunction* meet_function(int lanes) {
  if (lanes == 1) return &Meet::run<1>;
  int i = 0;
  while (kWidths[i] != lanes) ++i;
  return kernel<Meet>(kIsas[i]);
}

}  // namespace skybody
