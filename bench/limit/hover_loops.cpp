// Compiled once for each instruction set, with -march of its own and SKYBODY_LIMIT_ISA its name: a
// function of that target in a file for the lowest one (core/base/kernel_target.h) is lowered to
// that file's vectors too early, and g++ 12 then compares eight lanes one after another. Whatever
// is called here is inlined or has no linkage, so that no code for one set is run on another.
#include "bench/limit/hover_loops.h"

#include "bench/limit/hover_block.h"

namespace skybody::bench::limit {
namespace {

template <int W>
SKYBODY_INLINE void run_blocks(const LoopCall& call, int repeats) {
  auto* blocks = static_cast<HoverBlock<W>*>(call.blocks);
  for (int b = call.first; b < call.last; ++b) {
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(b) * W;
    const Rows rows{call.rows.action + at * kHoverActions,
                    call.rows.observation + at * kHoverObservation, call.rows.reward + at,
                    call.rows.ended + at};
    HoverStep<W>(blocks[b]).run(static_cast<std::uint64_t>(at), rows, repeats);
  }
}

// Not one for both: a loop of one physics step is none.
template <int W>
void run_once(const LoopCall& call) {
  run_blocks<W>(call, 1);
}
template <int W>
void run_often(const LoopCall& call) {
  run_blocks<W>(call, call.repeats);
}
template <int W>
void run(const LoopCall& call) {
  (call.repeats == 1 ? run_once<W> : run_often<W>)(call);
}

}  // namespace

#define SKYBODY_LIMIT_JOIN(a, b) a##b
#define SKYBODY_LIMIT_NAME(isa) SKYBODY_LIMIT_JOIN(hover_loops_, isa)

InstructionSetLoops SKYBODY_LIMIT_NAME(SKYBODY_LIMIT_ISA)() {
  InstructionSetLoops loops;
  loops.single = {"", 1, sizeof(HoverBlock<1>), kHoverObservation, &run<1>};
  loops.four = {"", 4, sizeof(HoverBlock<4>), kHoverObservation, &run<4>};
#ifdef __AVX512F__
  loops.eight = {"", 8, sizeof(HoverBlock<8>), kHoverObservation, &run<8>};
#endif
  return loops;
}

}  // namespace skybody::bench::limit
