// Compiled once for each instruction set, with -march of its own and SKYBODY_LIMIT_ISA its name: a
// function of that target in a file for the lowest one (core/base/kernel_target.h) is lowered to
// that file's vectors too early, and g++ 12 then compares eight lanes one after another. Whatever
// is called here is inlined or has no linkage, so that no code for one set is run on another.
#include "bench/limit/hover_task.h"
#include "bench/limit/loops.h"
#include "bench/limit/payload_task.h"
#include "bench/limit/pin_rod_task.h"

namespace skybody::bench::limit {
namespace {

template <class Task>
SKYBODY_INLINE void run_blocks(const LoopCall& call, int repeats) {
  using Step = BlockStep<Task>;
  auto* blocks = static_cast<typename Step::Memory*>(call.blocks);
  for (int b = call.first; b < call.last; ++b) {
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(b) * Step::W;
    const Rows rows{call.rows.action + at * kActions,
                    call.rows.observation + at * Task::kObservation, call.rows.reward + at,
                    call.rows.ended + at};
    Step(blocks[b]).run(static_cast<std::uint64_t>(at), rows, repeats);
  }
}

// Not one for both: a loop of one physics step is none.
template <class Task>
void run_once(const LoopCall& call) {
  run_blocks<Task>(call, 1);
}
template <class Task>
void run_often(const LoopCall& call) {
  run_blocks<Task>(call, call.repeats);
}
template <class Task>
void run(const LoopCall& call) {
  (call.repeats == 1 ? run_once<Task> : run_often<Task>)(call);
}

template <class Task>
LoopKind kind(const char* name) {
  using Step = BlockStep<Task>;
  return {name, Step::W, sizeof(typename Step::Memory), Task::kObservation, &run<Task>};
}

template <template <class> class Task>
std::vector<LoopKind> kinds() {
#ifdef __AVX512F__
  return {kind<Task<double>>("one by one, v4"), kind<Task<Pack<8>>>("8 lanes, v4"),
          kind<Task<Twin<Pack<8>>>>("2 x 8 lanes, v4")};
#elif defined(__AVX2__)
  return {kind<Task<double>>("one by one, v3"), kind<Task<Pack<4>>>("4 lanes, v3"),
          kind<Task<Twin<Pack<4>>>>("2 x 4 lanes, v3")};
#else
  return {kind<Task<double>>("one by one, v2")};
#endif
}

}  // namespace

#define SKYBODY_LIMIT_JOIN(a, b) a##b
#define SKYBODY_LIMIT_NAME(isa) SKYBODY_LIMIT_JOIN(loops_, isa)

Loops SKYBODY_LIMIT_NAME(SKYBODY_LIMIT_ISA)() {
  return {kinds<HoverTask>(), kinds<PayloadTask>(), kinds<PinRodTask>()};
}

}  // namespace skybody::bench::limit
