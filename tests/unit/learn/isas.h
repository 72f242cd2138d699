// The instruction sets of this machine, for tests that run on each.
#pragma once

#include <vector>

#include "core/base/isa.h"

namespace skybody::learn {

inline std::vector<Isa> isas() {
  std::vector<Isa> result;
  for (const Isa isa : kIsas) {
    if (machine_has(isa)) result.push_back(isa);
  }
  return result;
}

/// Those with fused multiply-add, which all give the same bits.
inline std::vector<Isa> fused_isas() {
#if SKYBODY_HAS_LEVELS
  std::vector<Isa> result = isas();
  std::erase(result, Isa::v2);
  return result;
#else
  return {};
#endif
}

}  // namespace skybody::learn
