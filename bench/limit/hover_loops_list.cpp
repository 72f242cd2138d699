#include "bench/limit/hover_loops.h"
#include "core/base/isa.h"

namespace skybody::bench::limit {

std::vector<LoopKind> hover_loops() {
  std::vector<LoopKind> out = hover_loops_v2();
  const auto add = [&](const std::vector<LoopKind>& more) {
    out.insert(out.end(), more.begin(), more.end());
  };
  if (machine_has(Isa::v3)) add(hover_loops_v3());
  if (machine_has(Isa::v4)) add(hover_loops_v4());
  return out;
}

}  // namespace skybody::bench::limit
