// Functions compiled for an instruction set above the file's own.
#pragma once

#include "core/base/isa_sets.h"

/// Before a function: compiles it, with all that it inlines, for TARGET ("arch=x86-64-v3").
// Unoptimised code is not inlined, and a call from v4 code to baseline code passes packs in other
// registers than it expects; AddressSanitizer makes flattened code slow to compile; and a file that
// is compiled for AVX cannot be inlined into v2 code. All kernels are then compiled as the file is,
// with the same bits.
#if defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__) && !defined(__AVX__)
#if SKYBODY_HAS_LEVELS
#define SKYBODY_KERNEL(TARGET) __attribute__((target(TARGET), flatten))
#else
#define SKYBODY_KERNEL(TARGET) __attribute__((flatten))
#endif
#else
#define SKYBODY_KERNEL(TARGET)
#endif
