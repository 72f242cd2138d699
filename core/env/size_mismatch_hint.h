// Advice for two controllers of a chain with the same signal but different sizes.
#pragma once

#include <string>

#include "core/plugin_abi/abi.h"

namespace skybody {

/// The parameters that set the sizes, as the end of a message.
/// @param given, taken  numbers of values
inline std::string size_mismatch_hint(int signal, int given, int taken) {
  constexpr int kPoint = SKYBODY_REFERENCE_VALUES;
  if (signal == SKYBODY_TRAJECTORY && given % kPoint == 0 && taken % kPoint == 0) {
    return ": " + std::to_string(given / kPoint) + " and " + std::to_string(taken / kPoint) +
           " points of " + std::to_string(kPoint) + " values. Set `points` of `reference` to " +
           std::to_string(taken / kPoint) +
           "; for `nmpc` with `preview` set `spacing` to its `node_step`, too";
  }
  constexpr int kAttitude = 5, kWithRates = 8;  // thrust and quaternion; with body rates
  if (signal == SKYBODY_ATTITUDE && given == kWithRates && taken == kAttitude) {
    return ": rates are the last three. Give `attitude` the parameter `feed_forward: true`";
  }
  if (signal == SKYBODY_ATTITUDE && given == kAttitude && taken == kWithRates) {
    return ": rates are missing. Give `attitude` the parameter `feed_forward: false`, or "
           "`position` `signal: trajectory`";
  }
  return ": parameters say how many values each takes and gives";
}

}  // namespace skybody
