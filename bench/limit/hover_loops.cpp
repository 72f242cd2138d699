// Compiled once for each instruction set, with -march of its own and SKYBODY_LIMIT_ISA its name: a
// function of that target in a file for the lowest one (core/base/kernel_target.h) is lowered to
// that file's vectors too early, and g++ 12 then compares eight lanes one after another. Whatever
// is called here is inlined or has no linkage, so that no code for one set is run on another.
#include "bench/limit/hover_loops.h"

#include "bench/limit/hover_block.h"

namespace skybody::bench::limit {
namespace {

template <class Real>
SKYBODY_INLINE void run_blocks(const LoopCall& call, int repeats) {
  auto* blocks = static_cast<HoverBlock<HoverStep<Real>::W>*>(call.blocks);
  for (int b = call.first; b < call.last; ++b) {
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(b) * HoverStep<Real>::W;
    const Rows rows{call.rows.action + at * kHoverActions,
                    call.rows.observation + at * kHoverObservation, call.rows.reward + at,
                    call.rows.ended + at};
    HoverStep<Real>(blocks[b]).run(static_cast<std::uint64_t>(at), rows, repeats);
  }
}

// Not one for both: a loop of one physics step is none.
template <class Real>
void run_once(const LoopCall& call) {
  run_blocks<Real>(call, 1);
}
template <class Real>
void run_often(const LoopCall& call) {
  run_blocks<Real>(call, call.repeats);
}
template <class Real>
void run(const LoopCall& call) {
  (call.repeats == 1 ? run_once<Real> : run_often<Real>)(call);
}

template <class Real>
LoopKind kind(const char* name) {
  constexpr int W = HoverStep<Real>::W;
  return {name, W, sizeof(HoverBlock<W>), kHoverObservation, &run<Real>};
}

}  // namespace

#define SKYBODY_LIMIT_JOIN(a, b) a##b
#define SKYBODY_LIMIT_NAME(isa) SKYBODY_LIMIT_JOIN(hover_loops_, isa)

std::vector<LoopKind> SKYBODY_LIMIT_NAME(SKYBODY_LIMIT_ISA)() {
  std::vector<LoopKind> loops;
#ifdef __AVX512F__
  loops = {kind<double>("one by one, v4"), kind<Pack<8>>("8 lanes, v4"),
           kind<Twin<Pack<8>>>("2 x 8 lanes, v4")};
#elif defined(__AVX2__)
  loops = {kind<double>("one by one, v3"), kind<Pack<4>>("4 lanes, v3"),
           kind<Twin<Pack<4>>>("2 x 4 lanes, v3")};
#else
  loops = {kind<double>("one by one, v2")};
#endif
  return loops;
}

}  // namespace skybody::bench::limit
