#include "learn/network/gru.h"

#include <algorithm>
#include <string>

#include "core/base/system/error.h"
#include "learn/network/growing_array.h"
#include "learn/network/initial_weights.h"
#include "learn/network/kernels/kernels.h"

namespace skybody::learn {
namespace {

constexpr int kMostUnits = 1 << 20;
constexpr int kGates = 3;

std::size_t area(int rows, int stride) {
  return static_cast<std::size_t>(rows) * static_cast<std::size_t>(stride);
}

/// Column of a gate's unit.
int column_of(int gate, int unit, int padded) { return gate * padded + unit; }

}  // namespace

Gru::Gru(int inputs, int units, Isa isa)
    : inputs_(inputs),
      units_(units),
      padded_(padded(units)),
      kernels_(&kernels_of(isa)),
      input_weight_{inputs, kGates * padded_},
      state_weight_{units, kGates * padded_} {
  for (const int size : {inputs, units}) {
    if (size >= 1 && size <= kMostUnits) continue;
    throw Error("a recurrent layer has " + std::to_string(inputs) + " inputs and " +
                std::to_string(units) + " units; allowed: 1.." + std::to_string(kMostUnits));
  }
  const auto width = static_cast<std::size_t>(kGates * padded_);
  input_bias_at_ = input_weight_.size();
  state_weight_at_ = input_bias_at_ + width;
  state_bias_at_ = state_weight_at_ + state_weight_.size();
  parameter_count_ = state_bias_at_ + width;
}

void Gru::initialize(std::span<float> parameters, std::uint64_t key, std::uint64_t stream) const {
  std::fill_n(parameters.begin(), parameter_count_, 0.0f);
  std::uint64_t step = 0;
  for (const bool is_state : {false, true}) {
    const PanelMatrix& weight = is_state ? state_weight_ : input_weight_;
    float* to = parameters.data() + (is_state ? state_weight_at_ : 0);
    for (int gate = 0; gate < kGates; ++gate) {
      const std::vector<double> values =
          orthogonal_matrix(weight.rows, units_, {key, stream, step++});
      for (int i = 0; i < weight.rows; ++i) {
        for (int u = 0; u < units_; ++u) {
          to[weight.at(i, column_of(gate, u, padded_))] =
              static_cast<float>(values[area(i, units_) + static_cast<std::size_t>(u)]);
        }
      }
    }
  }
}

void Gru::transpose(std::span<const float> parameters, TransposedGru& transposed) const {
  make_large_enough(transposed.input, input_weight_.transposed().size());
  make_large_enough(transposed.state, state_weight_.transposed().size());
  learn::transpose(input_weight_, parameters.data(), transposed.input.data());
  learn::transpose(state_weight_, parameters.data() + state_weight_at_, transposed.state.data());
}

void Gru::make_room(GruActivations& memory) const {
  const int rows = memory.sequences.rows();
  make_large_enough(memory.outputs, area(rows, padded_));
  make_large_enough(memory.before, area(rows, padded_));
  for (AlignedArray<float>* sums : {&memory.from_input, &memory.from_state, &memory.gates}) {
    make_large_enough(*sums, area(rows, kGates * padded_));
  }
}

void Gru::forward(std::span<const float> parameters, const float* x, int x_stride,
                  const Sequences& sequences, const std::uint8_t* begins, float* states,
                  GruActivations& memory) const {
  memory.sequences = sequences;
  make_room(memory);
  // Products with inputs do not depend on states: all rows at once.
  kernels_->multiply({
      .x = x,
      .x_stride = x_stride,
      .rows = sequences.rows(),
      .inner = inputs_,
      .weight = parameters.data(),
      .columns = kGates * padded_,
      .start = parameters.data() + input_bias_at_,
      .y = memory.from_input.data(),
      .y_stride = kGates * padded_,
  });
  for (int step = 0; step < sequences.steps; ++step) {
    begin_step(sequences, step, begins, states, memory);
    forward_step(parameters, sequences, step, memory);
  }
  for (int s = 0; s < sequences.count; ++s) {
    const std::size_t last = area(s * sequences.steps + sequences.steps - 1, padded_);
    std::copy_n(memory.outputs.data() + last, padded_, states + area(s, padded_));
  }
}

/// Stores the states before a step for the backward pass.
void Gru::begin_step(const Sequences& sequences, int step, const std::uint8_t* begins,
                     const float* states, GruActivations& memory) const {
  for (int s = 0; s < sequences.count; ++s) {
    const int row = s * sequences.steps + step;
    float* before = memory.before.data() + area(row, padded_);
    if (begins != nullptr && begins[row] != 0) {
      std::fill_n(before, padded_, 0.0f);
    } else {
      const float* from =
          step == 0 ? states + area(s, padded_) : memory.outputs.data() + area(row - 1, padded_);
      std::copy_n(from, padded_, before);
    }
  }
}

void Gru::forward_step(std::span<const float> parameters, const Sequences& sequences, int step,
                       GruActivations& memory) const {
  const int width = kGates * padded_;
  const std::size_t states_at = area(step, padded_), sums_at = area(step, width);
  kernels_->multiply({
      .x = memory.before.data() + states_at,
      .x_stride = sequences.steps * padded_,
      .rows = sequences.count,
      .inner = units_,
      .weight = parameters.data() + state_weight_at_,
      .columns = width,
      .start = parameters.data() + state_bias_at_,
      .y = memory.from_state.data() + sums_at,
      .y_stride = sequences.steps * width,
  });
  kernels_->gru({
      .from_input = memory.from_input.data() + sums_at,
      .from_state = memory.from_state.data() + sums_at,
      .state = memory.before.data() + states_at,
      .gates = memory.gates.data() + sums_at,
      .next = memory.outputs.data() + states_at,
      .rows = sequences.count,
      .units = padded_,
      .sum_stride = sequences.steps * width,
      .state_stride = sequences.steps * padded_,
      .next_stride = sequences.steps * padded_,
  });
}

void Gru::backward(const TransposedGru& transposed, const float* x, int x_stride,
                   const std::uint8_t* begins, GruActivations& memory, const float* dy,
                   int dy_stride, std::span<float> gradient, float* dx, int dx_stride) const {
  const Sequences& sequences = memory.sequences;
  const int rows = sequences.rows(), width = kGates * padded_;
  make_large_enough(memory.d_input, area(rows, width));
  make_large_enough(memory.d_state, area(rows, width));
  make_large_enough(memory.d_next, area(sequences.count, padded_));
  make_large_enough(memory.d_before, area(sequences.count, padded_));
  std::fill_n(memory.d_before.data(), area(sequences.count, padded_), 0.0f);
  for (int step = sequences.steps; step-- > 0;) {
    backward_step(transposed, step, begins, dy, dy_stride, memory);
  }
  kernels_->outer({
      .x = x,
      .x_stride = x_stride,
      .d = memory.d_input.data(),
      .d_stride = width,
      .rows = rows,
      .inner = inputs_,
      .columns = width,
      .gradient = gradient.data(),
      .bias = gradient.data() + input_bias_at_,
  });
  kernels_->outer({
      .x = memory.before.data(),
      .x_stride = padded_,
      .d = memory.d_state.data(),
      .d_stride = width,
      .rows = rows,
      .inner = units_,
      .columns = width,
      .gradient = gradient.data() + state_weight_at_,
      .bias = gradient.data() + state_bias_at_,
  });
  if (dx == nullptr) return;
  const int stride = input_weight_.transposed().padded_columns();
  make_large_enough(memory.d_x, area(rows, stride));
  kernels_->multiply({
      .x = memory.d_input.data(),
      .x_stride = width,
      .rows = rows,
      .inner = width,
      .weight = transposed.input.data(),
      .columns = stride,
      .start = nullptr,
      .y = memory.d_x.data(),
      .y_stride = stride,
  });
  for (int r = 0; r < rows; ++r) {
    std::copy_n(memory.d_x.data() + area(r, stride), inputs_, dx + area(r, dx_stride));
  }
}

/// From the gradient at the states after a step, in memory.d_before, to the gradient at the states
/// before it.
void Gru::backward_step(const TransposedGru& transposed, int step, const std::uint8_t* begins,
                        const float* dy, int dy_stride, GruActivations& memory) const {
  const Sequences& sequences = memory.sequences;
  const int width = kGates * padded_;
  const std::size_t states_at = area(step, padded_), sums_at = area(step, width);
  std::swap(memory.d_next, memory.d_before);
  for (int s = 0; s < sequences.count; ++s) {
    const float* from = dy + area(s * sequences.steps + step, dy_stride);
    float* to = memory.d_next.data() + area(s, padded_);
    for (int u = 0; u < units_; ++u) to[u] += from[u];
  }
  kernels_->gru_slope({
      .gates = memory.gates.data() + sums_at,
      .from_state = memory.from_state.data() + sums_at,
      .state = memory.before.data() + states_at,
      .d_next = memory.d_next.data(),
      .d_input = memory.d_input.data() + sums_at,
      .d_state = memory.d_state.data() + sums_at,
      .d_before = memory.d_before.data(),
      .rows = sequences.count,
      .units = padded_,
      .sum_stride = sequences.steps * width,
      .state_stride = sequences.steps * padded_,
      .d_stride = padded_,
  });
  kernels_->multiply({
      .x = memory.d_state.data() + sums_at,
      .x_stride = sequences.steps * width,
      .rows = sequences.count,
      .inner = width,
      .weight = transposed.state.data(),
      .columns = padded_,
      .start = memory.d_before.data(),
      .start_stride = padded_,
      .y = memory.d_before.data(),
      .y_stride = padded_,
  });
  for (int s = 0; begins != nullptr && s < sequences.count; ++s) {
    if (begins[s * sequences.steps + step] == 0) continue;
    std::fill_n(memory.d_before.data() + area(s, padded_), padded_, 0.0f);
  }
}

PolicyLayer Gru::layer(std::span<const float> parameters) const {
  PolicyLayer layer;
  layer.kind = LayerKind::kGru;
  layer.inputs = inputs_;
  layer.outputs = units_;
  for (int gate = 0; gate < kGates; ++gate) {
    for (int u = 0; u < units_; ++u) {
      const int column = column_of(gate, u, padded_);
      const auto value = [&](std::size_t at) { return static_cast<double>(parameters[at]); };
      for (int i = 0; i < inputs_; ++i) layer.weight.push_back(value(input_weight_.at(i, column)));
      for (int i = 0; i < units_; ++i) {
        layer.state_weight.push_back(value(state_weight_at_ + state_weight_.at(i, column)));
      }
      layer.bias.push_back(value(input_bias_at_ + static_cast<std::size_t>(column)));
      layer.state_bias.push_back(value(state_bias_at_ + static_cast<std::size_t>(column)));
    }
  }
  return layer;
}

void Gru::set_layer(const PolicyLayer& layer, std::span<float> parameters) const {
  if (layer.kind != LayerKind::kGru || layer.inputs != inputs_ || layer.outputs != units_) {
    throw Error("a policy's layer differs in kind or size from a recurrent layer of " +
                std::to_string(inputs_) + " inputs and " + std::to_string(units_) + " units");
  }
  std::fill_n(parameters.begin(), parameter_count_, 0.0f);
  for (int gate = 0; gate < kGates; ++gate) {
    for (int u = 0; u < units_; ++u) {
      const int column = column_of(gate, u, padded_), row = gate * units_ + u;
      const auto put = [&](std::size_t at, const std::vector<double>& from, std::size_t k) {
        parameters[at] = static_cast<float>(from[k]);
      };
      const auto k = static_cast<std::size_t>(row), c = static_cast<std::size_t>(column);
      for (int i = 0; i < inputs_; ++i) {
        put(input_weight_.at(i, column), layer.weight,
            area(row, inputs_) + static_cast<std::size_t>(i));
      }
      for (int i = 0; i < units_; ++i) {
        put(state_weight_at_ + state_weight_.at(i, column), layer.state_weight,
            area(row, units_) + static_cast<std::size_t>(i));
      }
      put(input_bias_at_ + c, layer.bias, k);
      put(state_bias_at_ + c, layer.state_bias, k);
    }
  }
}

}  // namespace skybody::learn
