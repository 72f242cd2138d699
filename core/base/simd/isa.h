// Selection of the kernels' instruction set. All variants give the same bits.
#pragma once

#include <cstdlib>
#include <string>

#include "core/base/simd/isa_sets.h"
#include "core/base/system/error.h"

namespace skybody {

/// In the order of isa_sets.h.
#define SKYBODY_ROW(NAME, LANES, TARGET) NAME = SKYBODY_ISA_##NAME,
enum class Isa { SKYBODY_ISAS(SKYBODY_ROW) };
#undef SKYBODY_ROW
#define SKYBODY_ROW(NAME, LANES, TARGET) Isa::NAME,
inline constexpr Isa kIsas[] = {SKYBODY_ISAS(SKYBODY_ROW)};
#undef SKYBODY_ROW
inline constexpr int kIsaCount = SKYBODY_ISA_COUNT;

/// The name in the environment variable SKYBODY_ISA.
inline const char* name(Isa isa) {
#define SKYBODY_ROW(NAME, LANES, TARGET) #NAME,
  static constexpr const char* kNames[] = {SKYBODY_ISAS(SKYBODY_ROW)};
#undef SKYBODY_ROW
  return kNames[static_cast<int>(isa)];
}

/// Whether this build contains kernels for the set itself.
constexpr bool has_kernels(Isa isa) {
#define SKYBODY_ROW(NAME, LANES, TARGET) SKYBODY_BUILDS_##NAME,
  constexpr bool kHas[] = {SKYBODY_ISAS(SKYBODY_ROW)};
#undef SKYBODY_ROW
  return kHas[static_cast<int>(isa)];
}

/// Whether this processor (and its operating system) supports the set.
#if SKYBODY_HAS_LEVELS
inline bool machine_has(Isa isa) {
  __builtin_cpu_init();
  // Tests single features: clang-tidy's front end does not support the names of the levels.
  const bool v2 = __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt");
  if (isa == Isa::v2) return v2;
  const bool v3 = v2 && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                  __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
  if (isa == Isa::v3) return v3;
  return v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512vl");
}
#else
inline bool machine_has(Isa) { return true; }
#endif

/// The names of the sets that the machine supports, separated by commas.
inline std::string machine_isas() {
  std::string names;
  for (const Isa isa : kIsas) {
    if (machine_has(isa)) names += (names.empty() ? "" : ", ") + std::string(name(isa));
  }
  return names;
}

/// The set named by the environment variable SKYBODY_ISA, or the highest one that the machine
/// supports. Reads the environment on every call: call once and store the result.
/// @throws Error (a std::runtime_error) if SKYBODY_ISA has another value or names a set that the
///         machine lacks, or if the machine lacks the lowest set.
inline Isa best_isa() {
  if (!machine_has(kIsas[0]))
    throw Error("this processor lacks x86-64-v2 (SSE4.2); Skybody needs it");
  const char* wanted = std::getenv("SKYBODY_ISA");
  const bool is_free = wanted == nullptr || *wanted == '\0';
  Isa highest = kIsas[0];
  for (const Isa isa : kIsas) {
    if (!is_free && std::string(wanted) == name(isa)) {
      if (machine_has(isa)) return isa;
      throw Error(std::string("SKYBODY_ISA is ") + wanted + ", but this machine has only " +
                  machine_isas() + "; choose one of these or unset it");
    }
    if (machine_has(isa)) highest = isa;
  }
  if (is_free) return highest;
  std::string allowed;
  for (const Isa isa : kIsas) allowed += (allowed.empty() ? "" : ", ") + std::string(name(isa));
  throw Error(std::string("SKYBODY_ISA is \"") + wanted + "\"; allowed: " + allowed);
}

}  // namespace skybody
