// The instruction sets of this machine, for tests that run on each.
#pragma once

#include <cstdlib>
#include <string>
#include <vector>

#include "core/base/simd/isa.h"

namespace skybody::learn {

inline std::vector<Isa> isas() {
  std::vector<Isa> result;
  for (const Isa isa : kIsas) {
    if (machine_has(isa)) result.push_back(isa);
  }
  return result;
}

/// The sets with fused multiply-add, which all give the same bits.
inline std::vector<Isa> fused_isas() {
#if SKYBODY_HAS_LEVELS
  std::vector<Isa> result = isas();
  std::erase(result, Isa::v2);
  return result;
#else
  return {};
#endif
}

/// Objects made in its scope use this set.
class ChosenIsa {
 public:
  explicit ChosenIsa(Isa isa) {
    if (const char* value = std::getenv("SKYBODY_ISA")) before_ = value;
    setenv("SKYBODY_ISA", name(isa), 1);
  }
  ~ChosenIsa() {
    if (before_.empty()) {
      unsetenv("SKYBODY_ISA");
    } else {
      setenv("SKYBODY_ISA", before_.c_str(), 1);
    }
  }
  ChosenIsa(const ChosenIsa&) = delete;
  ChosenIsa& operator=(const ChosenIsa&) = delete;

 private:
  std::string before_;
};

}  // namespace skybody::learn
