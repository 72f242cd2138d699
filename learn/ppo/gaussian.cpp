#include "learn/ppo/gaussian.h"

#include "core/base/kernels.h"
#include "core/base/math.h"
#include "core/base/pack.h"
#include "core/base/random.h"

namespace skybody::learn {
namespace {

constexpr std::uint64_t kNoiseStream = derive_stream("learn.noise");

// tanh |x| = (1 - e^(-2|x|)) / (1 + e^(-2|x|)), through expm1 so that small x lose nothing.
template <class Real>
SKYBODY_INLINE Real tanh(const Real& x) {
  const Real t = expm1(-2.0 * abs(x));
  return copysign(-t / (t + 2.0), x);
}

struct Tanh {
  template <int W>
  static SKYBODY_INLINE void run(float* values, std::size_t count) {
    for (std::size_t i = 0; i < count; i += W) {
      const std::size_t n = count - i < W ? count - i : W;
      double lanes[W] = {};
      for (std::size_t l = 0; l < n; ++l) lanes[l] = static_cast<double>(values[i + l]);
      store_lanes(lanes, tanh(load_lanes<Pack<W>>(lanes)));
      for (std::size_t l = 0; l < n; ++l) values[i + l] = static_cast<float>(lanes[l]);
    }
  }
};

// A lane is a row: its numbers do not depend on which rows are drawn beside it.
struct DrawNoise {
  template <int W>
  static SKYBODY_INLINE void run(const NoiseKey* key, int rows, int actions, float* noise) {
    using Real = Pack<W>;
    for (int r = 0; r < rows; r += W) {
      const int n = rows - r < W ? rows - r : W;
      Word<Real> ids(0);
      for (int l = 0; l < W; ++l) {
        set_lane(ids, l, key->first_row + static_cast<std::uint64_t>(r + l));
      }
      Random<Real> random(Word<Real>(key->seed), ids, Word<Real>(key->iteration),
                          Word<Real>(key->step), kNoiseStream, (1u << n) - 1u);
      for (int k = 0; k < actions; k += 2) {
        Real pair[2];
        random.normal_pair(pair[0], pair[1]);
        for (int j = 0; j < 2 && k + j < actions; ++j) {
          for (int l = 0; l < n; ++l) {
            noise[static_cast<std::ptrdiff_t>(r + l) * actions + k + j] =
                static_cast<float>(lane(pair[j], l));
          }
        }
      }
    }
  }
};

}  // namespace

void apply_tanh(float* values, std::size_t count, Isa isa) { kernel<Tanh>(isa)(values, count); }

void draw_noise(const NoiseKey& key, int rows, int actions, float* noise, Isa isa) {
  kernel<DrawNoise>(isa)(&key, rows, actions, noise);
}

void Deviations::update(std::span<const float> log_std) {
  deviation.resize(log_std.size());
  inverse.resize(log_std.size());
  log_sum = 0.0;
  for (std::size_t k = 0; k < log_std.size(); ++k) {
    const double log_deviation = static_cast<double>(log_std[k]);
    deviation[k] = exp(log_deviation);
    inverse[k] = exp(-log_deviation);
    log_sum += log_deviation;
  }
}

void draw_actions(const float* mean, const float* noise, int rows, const Deviations& deviations,
                  float* action, float* log_probability, int stride) {
  const std::size_t actions = deviations.deviation.size();
  for (int r = 0; r < rows; ++r) {
    double squares = 0.0;
    for (std::size_t k = 0; k < actions; ++k) {
      const double e = static_cast<double>(noise[k]);
      action[k] = static_cast<float>(static_cast<double>(mean[k]) + deviations.deviation[k] * e);
      squares += e * e;
    }
    *log_probability = static_cast<float>(-0.5 * squares - deviations.log_sum);
    mean += actions;
    noise += actions;
    action += stride;
    log_probability += stride;
  }
}

}  // namespace skybody::learn
