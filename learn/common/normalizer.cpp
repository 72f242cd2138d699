#include "learn/common/normalizer.h"

#include "core/base/simd/kernels.h"
#include "core/base/simd/lanes.h"

namespace skybody::learn {
namespace {

struct Call {
  float* rows;
  int count, stride, width;
  const double *mean, *scale;
  double bound;
  const ColumnSums* sums;
};

// Columns are independent: the compiler vectorizes the inner loops, with the same bits for every
// width.
struct Normalize {
  template <int W>
  static SKYBODY_INLINE void run(const Call* call) {
    const Call c = *call;
    for (int r = 0; r < c.count; ++r) {
      float* row = c.rows + static_cast<std::ptrdiff_t>(r) * c.stride;
      if (c.sums != nullptr) add(row, c.width, c.mean, c.sums->sum, c.sums->squares);
      normalize(row, c.width, c.mean, c.scale, c.bound);
    }
  }

  static SKYBODY_INLINE void add(const float* __restrict row, int width,
                                 const double* __restrict mean, double* __restrict sum,
                                 double* __restrict squares) {
    for (int k = 0; k < width; ++k) {
      const double d = static_cast<double>(row[k]) - mean[k];
      sum[k] += d;
      squares[k] += d * d;
    }
  }

  static SKYBODY_INLINE void normalize(float* __restrict row, int width,
                                       const double* __restrict mean,
                                       const double* __restrict scale, double bound) {
    for (int k = 0; k < width; ++k) {
      const double x = (static_cast<double>(row[k]) - mean[k]) * scale[k];
      const double below = x < bound ? x : bound;
      row[k] = static_cast<float>(below > -bound ? below : -bound);
    }
  }
};

}  // namespace

void Normalizer::apply(float* rows, int count, int stride, std::span<const double> mean,
                       std::span<const double> scale, const ColumnSums* sums) const {
  const Call call{rows,        count,        stride, static_cast<int>(mean.size()),
                  mean.data(), scale.data(), bound_, sums};
  kernel<Normalize>(isa_)(&call);
}

}  // namespace skybody::learn
