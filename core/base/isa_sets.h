/* The instruction sets that a build has kernels for, in one list. Plain C: the ABI counts them.
 *
 * X(name, lanes of a pack of doubles, the compiler's target), the lowest first. On x86-64 the
 * levels of its psABI: v2 has SSE4.2, v3 AVX2 and FMA, v4 AVX-512 (F, BW, CD, DQ, VL). On other
 * processors, and with SKYBODY_PORTABLE (CMake), one set: what the compiler makes of packs of two
 * by itself.
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

/* Which of them a build has kernels for; a set without runs those of the next lower one, with the
 * same bits. All, unless SKYBODY_KERNELS (CMake) says less. */
#define SKYBODY_BUILDS_portable 1
#define SKYBODY_BUILDS_v2 1
#ifndef SKYBODY_BUILDS_v3
#define SKYBODY_BUILDS_v3 1
#endif
#ifndef SKYBODY_BUILDS_v4
#define SKYBODY_BUILDS_v4 1
#endif

#define SKYBODY_ROW(NAME, LANES, TARGET) SKYBODY_ISA_##NAME,
enum SkybodyIsa { SKYBODY_ISAS(SKYBODY_ROW) SKYBODY_ISA_COUNT };
#undef SKYBODY_ROW

#endif /* SKYBODY_CORE_BASE_ISA_SETS_H */
