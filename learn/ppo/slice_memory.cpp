#include "learn/ppo/slice_memory.h"

#include <algorithm>

#include "learn/network/panel_matrix.h"
#include "learn/network/product.h"

namespace skybody::learn {
SliceMemory::SliceMemory(int units, int steps, int rows) : steps_(steps) {
  if (units == 0) return;
  stride_ = padded(units);
  states_ = AlignedArray<float>(product(rows, stride_));
  first_states_ = AlignedArray<float>(states_.size());
  is_fresh_.resize(static_cast<std::size_t>(rows), 1);
  episode_begins_.resize(product(steps, rows));
}

void SliceMemory::begin() { std::copy_n(states_.data(), states_.size(), first_states_.data()); }

void SliceMemory::recall(std::size_t at, int first, int count, PolicySteps& steps) {
  if (!exists()) return;
  const std::uint8_t* fresh = is_fresh_.data() + first;
  std::copy_n(fresh, count, episode_begins_.data() + at);
  steps.begins = fresh;
  steps.states = states_.data() + product(first, stride_);
}

void SliceMemory::gather(const int* order, int count, std::uint8_t* begins, float* states,
                         PolicySteps& steps) const {
  if (!exists()) return;
  const auto stride = static_cast<std::size_t>(stride_);
  for (int r = 0; r < count; ++r) begins[r] = episode_begins_[static_cast<std::size_t>(order[r])];
  steps.sequences = {count / steps_, steps_};
  steps.begins = begins;
  steps.states = states;
  for (int s = 0; s < steps.sequences.count; ++s) {
    const auto row = static_cast<std::size_t>(order[s * steps_]);  // of the first step
    std::copy_n(first_states_.data() + row * stride, stride,
                states + static_cast<std::size_t>(s) * stride);
  }
}

}  // namespace skybody::learn
