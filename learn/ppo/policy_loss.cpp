#include "learn/ppo/policy_loss.h"

#include <algorithm>

#include "core/base/math/math.h"
#include "core/base/simd/kernels.h"
#include "core/base/simd/pack.h"
#include "core/base/system/error.h"

namespace skybody::learn {
namespace {

struct Exponentials {
  template <int W>
  static SKYBODY_INLINE void run(const double* x, int count, double* y) {
    for (int i = 0; i < count; i += W) store_lanes(y + i, exp(load_lanes<Pack<W>>(x + i)));
  }
};

constexpr int kWhole = 8;  // lanes of the widest pack

/// ln of the current density over the density when the action was drawn.
double log_ratio_of(const float* action, const float* mean, double log_probability,
                    const Deviations& deviations) {
  double squares = 0.0;
  for (std::size_t k = 0; k < deviations.inverse.size(); ++k) {
    const double z =
        (static_cast<double>(action[k]) - static_cast<double>(mean[k])) * deviations.inverse[k];
    squares += z * z;
  }
  return -0.5 * squares - deviations.log_sum - log_probability;
}

}  // namespace

PolicyLoss::PolicyLoss(int most_rows, Isa isa)
    : isa_(isa),
      log_ratio_(static_cast<std::size_t>((most_rows + kWhole - 1) / kWhole * kWhole)),
      ratio_(log_ratio_.size()) {}

void PolicyLoss::apply(const PolicyRows& rows, const Deviations& deviations,
                       const PolicyLossTerms& terms, float* gradient,
                       std::span<double> log_std_gradient, PolicyFigures& figures) {
  SKYBODY_DEMAND(rows.count <= static_cast<int>(ratio_.size()), "too many rows at a time");
  const std::size_t actions = deviations.inverse.size();
  const auto at = [&](const float* first, int r) {
    return first + static_cast<std::ptrdiff_t>(r) * rows.stride;
  };
  const float* mean = rows.mean;
  for (int r = 0; r < rows.count; ++r, mean += actions) {
    const double before = static_cast<double>(*at(rows.log_probability, r));
    log_ratio_[static_cast<std::size_t>(r)] =
        log_ratio_of(at(rows.action, r), mean, before, deviations);
  }
  kernel<Exponentials>(isa_)(log_ratio_.data(), rows.count, ratio_.data());

  mean = rows.mean;
  for (int r = 0; r < rows.count; ++r, mean += actions, gradient += actions) {
    const auto i = static_cast<std::size_t>(r);
    const double ratio = ratio_[i];
    const double advantage = (static_cast<double>(*at(rows.advantage, r)) - terms.advantage_mean) *
                             terms.advantage_scale;
    const double clipped = std::clamp(ratio, 1.0 - terms.clip_range, 1.0 + terms.clip_range);
    figures.loss -= std::min(advantage * ratio, advantage * clipped);
    figures.kl += ratio - 1.0 - log_ratio_[i];
    figures.clipped += ratio != clipped ? 1.0 : 0.0;
    // Where the clipped term is the smaller one, its derivative is zero.
    const bool counts = advantage >= 0.0 ? ratio <= clipped : ratio >= clipped;
    const double slope = counts ? -advantage * ratio * terms.weight : 0.0;
    const float* action = at(rows.action, r);
    for (std::size_t k = 0; k < actions; ++k) {
      const double m = static_cast<double>(mean[k]);
      const double z = (static_cast<double>(action[k]) - m) * deviations.inverse[k];
      const double at_mean = slope * z * deviations.inverse[k];
      gradient[k] = static_cast<float>(terms.is_bounded ? at_mean * (1.0 - m * m) : at_mean);
      log_std_gradient[k] += slope * (z * z - 1.0);
    }
  }
}

}  // namespace skybody::learn
