// Loops over arrays, value by value. A remainder of fewer than sixteen values goes through a padded
// copy, so that the same instructions compute every value.
#pragma once

#include "learn/network/kernels/functions.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

/// Up to sixteen values of an array: load and store of a loop's remainder.
struct Rest {
  float value[kLanes];

  explicit Rest(float fill) {
    for (float& v : value) v = fill;
  }
  void take(const float* from, size_t count) {
    for (size_t i = 0; i < count; ++i) value[i] = from[i];
  }
  void give(float* to, size_t count) const {
    for (size_t i = 0; i < count; ++i) to[i] = value[i];
  }
};

/// y = function(x)
/// @param fill  a valid argument of the function, for padding
template <class Function>
SKYBODY_KERNEL void map(const float* x, float* y, size_t count, float fill,
                        const Function& function) {
  size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) store(y + i, function(load(x + i)));
  if (i == count) return;
  Rest rest(fill);
  rest.take(x + i, count - i);
  store(rest.value, function(load(rest.value)));
  rest.give(y + i, count - i);
}

inline void map_tanh(const float* x, float* y, size_t count) {
  map(x, y, count, 0.0f, [](const Floats& a) { return tanh(a); });
}

inline void add(const float* addend, float* sum, size_t count) {
  size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) store(sum + i, load(sum + i) + load(addend + i));
  for (; i < count; ++i) sum[i] += addend[i];
}

/// One step for sixteen values in place; the equations are in adam.h.
SKYBODY_KERNEL void adam_step(const AdamScalars& s, const float* gradient, float* first,
                              float* second, float* parameters) {
  const Floats g = floats(s.gradient_scale) * load(gradient);
  const Floats m = fma(floats(s.first_rest), g - load(first), load(first));
  const Floats v = fma(floats(s.second_rest) * g, g, floats(s.second_decay) * load(second));
  const Floats deviation = fma(sqrt(v), floats(s.second_unbias), floats(s.epsilon));
  store(first, m);
  store(second, v);
  store(parameters, fma(floats(-s.rate), m / deviation, load(parameters)));
}

inline void adam(const AdamScalars& scalars, const float* gradient, float* first, float* second,
                 float* parameters, size_t count) {
  size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    adam_step(scalars, gradient + i, first + i, second + i, parameters + i);
  }
  if (i == count) return;
  const size_t left_over = count - i;
  Rest g(0.0f), m(0.0f), v(0.0f), p(0.0f);
  g.take(gradient + i, left_over);
  m.take(first + i, left_over);
  v.take(second + i, left_over);
  p.take(parameters + i, left_over);
  adam_step(scalars, g.value, m.value, v.value, p.value);
  m.give(first + i, left_over);
  v.give(second + i, left_over);
  p.give(parameters + i, left_over);
}

inline double sum_of_lanes(const Floats& a) {
  float lane[kLanes];
  store(lane, a);
  double sum = 0.0;
  for (const float v : lane) sum += static_cast<double>(v);
  return sum;
}

inline double square_sum(const float* values, size_t count) {
  constexpr size_t kBlock = 1024;
  double sum = 0.0;
  size_t i = 0;
  while (i + kLanes <= count) {
    const size_t end = count - i < kBlock ? count : i + kBlock;
    Floats block = floats(0.0f);
    for (; i + kLanes <= end; i += kLanes) block = fma(load(values + i), load(values + i), block);
    sum += sum_of_lanes(block);
  }
  for (; i < count; ++i) sum += static_cast<double>(values[i]) * static_cast<double>(values[i]);
  return sum;
}

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
