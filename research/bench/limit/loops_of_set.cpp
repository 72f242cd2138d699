// Compiled once for each instruction set, with its own -march and SKYBODY_LIMIT_ISA as its name.
// The alternative, a function of that target in a file for the lowest one
// (core/base/simd/kernel_target.h), is lowered to that file's vectors too early, and g++ 12 then
// compares eight lanes one after another. All callees are inlined or have no linkage, so that no
// code for one set runs on another.
#include "research/bench/limit/hover_task.h"
#include "research/bench/limit/loops.h"
#include "research/bench/limit/payload_task.h"
#include "research/bench/limit/pin_rod_task.h"
#include "research/bench/limit/team_step.h"

namespace skybody::bench::limit {
namespace {

template <class Step>
SKYBODY_INLINE void run_blocks(const LoopCall& call, int repeats) {
  auto* blocks = static_cast<typename Step::Memory*>(call.blocks);
  for (int b = call.first; b < call.last; ++b) {
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(b) * Step::W;
    const Rows rows{call.rows.action + at * Step::kActions,
                    call.rows.observation + at * Step::kObservation, call.rows.reward + at,
                    call.rows.ended + at};
    Step(blocks[b]).run(static_cast<std::uint64_t>(at), rows, repeats);
  }
}

// Separate code for one physics step, which needs no loop.
template <class Step>
void run_once(const LoopCall& call) {
  run_blocks<Step>(call, 1);
}
template <class Step>
void run_often(const LoopCall& call) {
  run_blocks<Step>(call, call.repeats);
}
template <class Step>
void run(const LoopCall& call) {
  (call.repeats == 1 ? run_once<Step> : run_often<Step>)(call);
}

template <class Step>
LoopKind kind(const char* name) {
  return {name,           Step::W,   sizeof(typename Step::Memory), Step::kObservation,
          Step::kActions, &run<Step>};
}

template <template <class> class Task>
struct StepOf {
  template <class Real>
  using Type = BlockStep<Task<Real>>;
};
template <int N>
struct TeamOf {
  template <class Real>
  using Type = TeamStep<Real, N>;
};

/// @tparam Steps  Type<Real>: the step of environments in a Real
template <class Steps>
std::vector<LoopKind> kinds() {
#ifdef __AVX512F__
  using Wide = Pack<8>;
  constexpr const char* kNames[] = {"one by one, v4", "8 lanes, v4", "2 x 8 lanes, v4"};
#elif defined(__AVX2__)
  using Wide = Pack<4>;
  constexpr const char* kNames[] = {"one by one, v3", "4 lanes, v3", "2 x 4 lanes, v3"};
#else
  return {kind<typename Steps::template Type<double>>("one by one, v2")};
#endif
#ifdef __AVX2__
  return {kind<typename Steps::template Type<double>>(kNames[0]),
          kind<typename Steps::template Type<Wide>>(kNames[1]),
          kind<typename Steps::template Type<Twin<Wide>>>(kNames[2])};
#endif
}

}  // namespace

#define SKYBODY_LIMIT_JOIN(a, b) a##b
#define SKYBODY_LIMIT_NAME(isa) SKYBODY_LIMIT_JOIN(loops_, isa)

Loops SKYBODY_LIMIT_NAME(SKYBODY_LIMIT_ISA)() {
  return {kinds<StepOf<HoverTask>>(), kinds<StepOf<PayloadTask>>(), kinds<StepOf<PinRodTask>>(),
          kinds<TeamOf<2>>(), kinds<TeamOf<20>>()};
}

}  // namespace skybody::bench::limit
