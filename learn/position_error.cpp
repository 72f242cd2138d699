#include "learn/position_error.h"

#include <cmath>

namespace skybody::learn {

double PositionError::of(const float* info) const {
  double squares = 0.0;
  for (int k = first; k < first + count; ++k) {
    squares += static_cast<double>(info[k]) * static_cast<double>(info[k]);
  }
  return std::sqrt(squares);
}

PositionError find_position_error(const CompiledScenario& compiled) {
  for (const char* name : kPositionErrors) {
    int first = 0;
    for (const Channel& channel : compiled.info_channels()) {
      if (channel.name == name) return {first, channel.count};
      first += channel.count;
    }
  }
  return {};
}

}  // namespace skybody::learn
