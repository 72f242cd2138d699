// Compiles functions for a higher instruction set than the file's own.
#pragma once

#include "core/base/simd/isa_sets.h"

/// Before a function: compiles it, with all inlined functions, for TARGET ("arch=x86-64-v3").
// The macro is empty, and all kernels use the file's own set with the same bits, in three cases:
// - without optimisation nothing is inlined, and v4 code and baseline code pass packs in different
//   registers;
// - with AddressSanitizer, flattened code compiles slowly;
// - a file compiled for AVX cannot be inlined into v2 code.
#if defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__) && !defined(__AVX__)
#if SKYBODY_HAS_LEVELS
#define SKYBODY_KERNEL(TARGET) __attribute__((target(TARGET), flatten))
#else
#define SKYBODY_KERNEL(TARGET) __attribute__((flatten))
#endif
#else
#define SKYBODY_KERNEL(TARGET)
#endif
