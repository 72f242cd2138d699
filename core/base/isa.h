// Which instruction-set variant of the kernels to run. All variants give the same bits.
#pragma once

#include <cstdlib>
#include <string>

#include "core/base/error.h"

namespace skybody {

/// Levels of the x86-64 psABI: v2 has SSE4.2, v3 AVX2 and FMA, v4 AVX-512 (F, BW, CD, DQ, VL).
enum class Isa { v2, v3, v4 };
inline constexpr int kIsaCount = 3;

/// "v2", "v3" or "v4".
inline const char* name(Isa isa) { return isa == Isa::v4 ? "v4" : isa == Isa::v3 ? "v3" : "v2"; }

/// Whether this processor (and its operating system) runs the level.
inline bool machine_has(Isa isa) {
  __builtin_cpu_init();
  // Feature by feature: clang-tidy's front end does not know the names of the levels.
  const bool v2 = __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt");
  if (isa == Isa::v2) return v2;
  const bool v3 = v2 && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                  __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
  if (isa == Isa::v3) return v3;
  return v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512vl");
}

/// The highest level that the machine has, or the one that the environment variable SKYBODY_ISA
/// (v2, v3 or v4) names. Reads the environment at every call: call once and keep the answer.
/// @throws Error (a std::runtime_error) if SKYBODY_ISA is something else, or a level that the
///         machine lacks, or if the machine lacks even v2.
inline Isa best_isa() {
  const Isa highest = machine_has(Isa::v4) ? Isa::v4 : machine_has(Isa::v3) ? Isa::v3 : Isa::v2;
  if (!machine_has(Isa::v2))
    throw Error("this processor lacks x86-64-v2 (SSE4.2); Skybody needs it");
  const char* wanted = std::getenv("SKYBODY_ISA");
  if (wanted == nullptr || *wanted == '\0') return highest;
  for (const Isa isa : {Isa::v2, Isa::v3, Isa::v4}) {
    if (std::string(wanted) != name(isa)) continue;
    if (machine_has(isa)) return isa;
    throw Error(std::string("SKYBODY_ISA is ") + wanted + ", but this machine has only v2.." +
                name(highest) + "; choose one of these or unset it");
  }
  throw Error(std::string("SKYBODY_ISA is \"") + wanted + "\"; allowed: v2, v3, v4");
}

}  // namespace skybody
