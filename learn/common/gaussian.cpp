#include "learn/common/gaussian.h"

#include "core/base/math/math.h"
#include "core/base/math/random.h"
#include "learn/network/kernels/kernels.h"
#include "learn/network/noise.h"

namespace skybody::learn {

void apply_tanh(float* values, std::size_t count, Isa isa) {
  kernels_of(isa).tanh(values, values, count);
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

void draw_noise(const NoiseSource& source, std::span<float> values, Isa isa) {
  constexpr std::uint64_t kNoiseStream = derive_stream("learn.noise");
  draw_normals({{source.seed, source.slice}, source.rollout, kNoiseStream, source.step}, values,
               isa);
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
