#include "research/bench/limit/loops.h"

#include "core/base/simd/isa.h"

namespace skybody::bench::limit {
namespace {

void append(std::vector<LoopKind>& to, const std::vector<LoopKind>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

void append(Loops& to, const Loops& more) {
  append(to.hover, more.hover);
  append(to.payload, more.payload);
  append(to.pin_rod, more.pin_rod);
  append(to.team_of_2, more.team_of_2);
  append(to.team_of_20, more.team_of_20);
}

}  // namespace

Loops all_loops() {
  Loops out = loops_v2();
  if (machine_has(Isa::v3)) append(out, loops_v3());
  if (machine_has(Isa::v4)) append(out, loops_v4());
  return out;
}

}  // namespace skybody::bench::limit
