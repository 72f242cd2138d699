// The floating-point mode: the settings that threads and compiled files need.
#pragma once

#ifdef __SSE2__
#include <xmmintrin.h>
#endif

#include <cfenv>
#include <cstdint>
#include <cstring>

namespace skybody {

#ifdef __SSE2__

/// MXCSR at process start: round to nearest even, denormals kept, all exceptions masked.
constexpr std::uint32_t kStandardMxcsr = 0x1f80;
/// x87 control word at process start: extended precision, nearest even, all masked.
constexpr std::uint16_t kStandardX87 = 0x037f;

/// Sets this thread's floating-point mode. For Skybody's own threads.
inline void set_fp_environment() {
  const std::uint16_t x87 = kStandardX87;
  asm volatile("fldcw %0" : : "m"(x87));
  _mm_setcsr(kStandardMxcsr);
}

/// Whether SSE on this thread rounds to nearest even, keeps denormals and masks all exceptions.
inline bool has_standard_fp_environment() {
  return (_mm_getcsr() & ~0x3fu) == kStandardMxcsr;  // the low six bits are sticky flags
}

/// RAII guard: sets the floating-point mode of the caller's thread and restores the previous mode.
class FpEnvironment {
 public:
  FpEnvironment() : mxcsr_(_mm_getcsr()), x87_(x87_control()) { set(kStandardMxcsr, kStandardX87); }
  ~FpEnvironment() { set(mxcsr_, x87_); }
  FpEnvironment(const FpEnvironment&) = delete;
  FpEnvironment& operator=(const FpEnvironment&) = delete;

 private:
  static std::uint16_t x87_control() {
    std::uint16_t x87 = 0;
    asm volatile("fnstcw %0" : "=m"(x87));
    return x87;
  }
  /// Writes a register only if it differs: writing takes much longer than reading. The low six bits
  /// of MXCSR are sticky flags.
  static void set(std::uint32_t mxcsr, std::uint16_t x87) {
    if (((_mm_getcsr() ^ mxcsr) & ~0x3fu) != 0) _mm_setcsr(mxcsr);
    if (x87_control() != x87) asm volatile("fldcw %0" : : "m"(x87));
  }
  std::uint32_t mxcsr_;
  std::uint16_t x87_;
};

#else  // the same with the C library, for other processors

inline void set_fp_environment() { std::fesetenv(FE_DFL_ENV); }

inline bool has_standard_fp_environment() { return std::fegetround() == FE_TONEAREST; }

class FpEnvironment {
 public:
  FpEnvironment() {
    std::fegetenv(&before_);
    set_fp_environment();
  }
  ~FpEnvironment() { std::fesetenv(&before_); }
  FpEnvironment(const FpEnvironment&) = delete;
  FpEnvironment& operator=(const FpEnvironment&) = delete;

 private:
  std::fenv_t before_;
};

#endif

/// Result of fp_probe() in correctly compiled files.
constexpr std::uint64_t kFpProbeExpected = 0x6e0710ccc5a2c876ull;

/// Runs a few double operations at run time and hashes their bits. The hash differs from
/// kFpProbeExpected if the file was compiled with FMA contraction, reassociation, reciprocals,
/// finite-math or x87 (-Ofast, -ffast-math, -ffp-contract=fast with FMA, -mfpmath=387, ...).
/// `static`: every including file compiles its own copy, in its own mode. Run it under
/// FpEnvironment.
[[gnu::noinline]] static inline std::uint64_t fp_probe() {
  std::uint64_t hash = 0xcbf29ce484222325ull;
  const auto add = [&hash](double value) {
    volatile double stored = value;
    const double read = stored;
    std::uint64_t word;
    std::memcpy(&word, &read, sizeof(word));
    hash = (hash ^ word) * 0x100000001b3ull;
    hash ^= hash >> 29;
  };
  volatile double inputs[] = {1.0 + 0x1p-30, 1.0 + 0x1p-29, 0x1p60, 3.0, 0.0, -0.0, 0x1p-60, 0.1};
  const double a = inputs[0], b = inputs[1], big = inputs[2], three = inputs[3];
  const double zero = inputs[4], minus_zero = inputs[5], small = inputs[6], tenth = inputs[7];
  // Contraction: a a rounds to b; a fused operation leaves 2^-60.
  add(a * a - b);
  add(b - a * a);
  add(-(a * a) + b);
  // Reassociation.
  add((three + big) - big);
  add((tenth + three) - three);
  add((tenth * three) * a - tenth * (three * a));
  // Extended precision: 1 + 2^-60 is 1.
  add((a + small) - a);
  // Reciprocals: x / 3 is not x (1/3).
  add(b / three);
  add(tenth / three);
  add(a / three);
  add(5.0 * tenth / three);
  // NaN and signed zeros as in IEEE 754.
  const double nan = zero / zero;
  add(nan != nan ? 1.0 : 2.0);
  add(minus_zero + 0.0);
  add(0.0 - zero);
  add(minus_zero + zero);
  add(zero - three * zero);
  // A sum over an array, in order: vectorising it needs reassociation.
  double terms[32];
  for (int i = 0; i < 32; ++i) terms[i] = inputs[i & 7] * (i + tenth);
  terms[2] = terms[10] = terms[18] = terms[26] = tenth;
  double sum = 0.0;
  for (int i = 0; i < 32; ++i) sum += terms[i] * terms[31 - i];
  add(sum);
  return hash;
}

}  // namespace skybody
