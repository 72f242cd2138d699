// Numbers within an episode's status, above the bits that describe its end.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/model/state_layout.h"

namespace skybody {

/// All fields together end below 2^53, so that a double represents a status exactly.
struct StatusField {
  int place, bits;

  std::uint64_t most() const { return (std::uint64_t{1} << bits) - 1; }
  std::uint64_t put(double value) const {
    return static_cast<std::uint64_t>(std::clamp(value, 0.0, static_cast<double>(most()))) << place;
  }
  std::uint64_t get(std::uint64_t status) const { return status >> place & most(); }
};

}  // namespace skybody
