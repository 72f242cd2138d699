/* The instruction sets of a build's kernels, in one list. Plain C: the ABI counts them.
 *
 * X(name, lanes of a pack of doubles, the compiler's target), in ascending order. On x86-64 these
 * are the levels of its psABI: v2 has SSE4.2, v3 AVX2 and FMA, v4 AVX-512 (F, BW, CD, DQ, VL). On
 * other processors, and with SKYBODY_PORTABLE (CMake), there is one set: packs of two, compiled for
 * the compiler's default target.
 */
#ifndef SKYBODY_CORE_BASE_ISA_SETS_H
#define SKYBODY_CORE_BASE_ISA_SETS_H

#if defined(__x86_64__) && !defined(SKYBODY_PORTABLE)
#define SKYBODY_HAS_LEVELS 1
#define SKYBODY_ISAS(X)      \
  X(v2, 2, "arch=x86-64-v2") \
  X(v3, 4, "arch=x86-64-v3") \
  X(v4, 8, "arch=x86-64-v4")
#else
#define SKYBODY_HAS_LEVELS 0
#define SKYBODY_ISAS(X) X(portable, 2, "")
#endif

/* Sets with kernels of their own; the other sets run the kernels of the next lower one, with the
 * same bits. All by default; SKYBODY_KERNELS (CMake) reduces them. */
#define SKYBODY_BUILDS_portable 1 /* NOLINT(readability-identifier-naming): as the set */
#define SKYBODY_BUILDS_v2 1       /* NOLINT(readability-identifier-naming): as the set */
#ifndef SKYBODY_BUILDS_v3
#define SKYBODY_BUILDS_v3 1 /* NOLINT(readability-identifier-naming): as the set */
#endif
#ifndef SKYBODY_BUILDS_v4
#define SKYBODY_BUILDS_v4 1 /* NOLINT(readability-identifier-naming): as the set */
#endif

#define SKYBODY_ROW(NAME, LANES, TARGET) SKYBODY_ISA_##NAME,
enum SkybodyIsa { SKYBODY_ISAS(SKYBODY_ROW) SKYBODY_ISA_COUNT };
#undef SKYBODY_ROW

#endif /* SKYBODY_CORE_BASE_ISA_SETS_H */
