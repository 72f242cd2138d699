// Seconds of wall-clock time for reports. Results do not depend on them.
#pragma once

#include <chrono>

namespace skybody::learn {

using Clock = std::chrono::steady_clock;

/// [s]
inline double seconds_between(Clock::time_point begin, Clock::time_point end) {
  return std::chrono::duration<double>(end - begin).count();
}

/// [s]
inline double seconds_since(Clock::time_point begin) {
  return seconds_between(begin, Clock::now());
}

}  // namespace skybody::learn
