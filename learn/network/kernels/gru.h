// Gates of gated recurrent units and their derivatives, row by row. The equations are in
// learn/network/gru.h.
#pragma once

#include "learn/network/kernels/functions.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

inline void gru(const GruCall& call) {
  const int units = call.units;
  for (ptrdiff_t r = 0; r < call.rows; ++r) {
    const float* a = call.from_input + r * call.sum_stride;
    const float* c = call.from_state + r * call.sum_stride;
    const float* state = call.state + r * call.state_stride;
    float* gates = call.gates + r * call.sum_stride;
    float* next = call.next + r * call.next_stride;
    for (int u = 0; u < units; u += kLanes) {
      const Floats reset = sigmoid(load(a + u) + load(c + u));
      const Floats update = sigmoid(load(a + units + u) + load(c + units + u));
      const Floats candidate = tanh(fma(reset, load(c + 2 * units + u), load(a + 2 * units + u)));
      store(gates + u, reset);
      store(gates + units + u, update);
      store(gates + 2 * units + u, candidate);
      store(next + u, fma(update, load(state + u) - candidate, candidate));
    }
  }
}

inline void gru_slope(const GruSlopeCall& call) {
  const int units = call.units;
  const Floats one = floats(1.0f);
  for (ptrdiff_t r = 0; r < call.rows; ++r) {
    const float* gates = call.gates + r * call.sum_stride;
    const float* candidate_sum = call.from_state + r * call.sum_stride + 2 * units;
    const float* state = call.state + r * call.state_stride;
    const float* d_next = call.d_next + r * call.d_stride;
    float* d_input = call.d_input + r * call.sum_stride;
    float* d_state = call.d_state + r * call.sum_stride;
    float* d_before = call.d_before + r * call.d_stride;
    for (int u = 0; u < units; u += kLanes) {
      const Floats reset = load(gates + u), update = load(gates + units + u);
      const Floats candidate = load(gates + 2 * units + u), d = load(d_next + u);
      const Floats d_candidate = d * (one - update) * fma(candidate, floats(0.0f) - candidate, one);
      const Floats d_reset = d_candidate * load(candidate_sum + u) * reset * (one - reset);
      const Floats d_update = d * (load(state + u) - candidate) * update * (one - update);
      store(d_input + u, d_reset);
      store(d_input + units + u, d_update);
      store(d_input + 2 * units + u, d_candidate);
      store(d_state + u, d_reset);
      store(d_state + units + u, d_update);
      store(d_state + 2 * units + u, d_candidate * reset);
      store(d_before + u, d * update);
    }
  }
}

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
