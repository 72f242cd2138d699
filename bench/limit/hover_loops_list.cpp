#include "bench/limit/hover_loops.h"
#include "core/base/isa.h"

namespace skybody::bench::limit {
namespace {

LoopKind named(LoopKind loop, const char* name) {
  loop.name = name;
  return loop;
}

}  // namespace

std::vector<LoopKind> hover_loops() {
  std::vector<LoopKind> out{named(hover_loops_v2().single, "one by one, v2")};
  if (machine_has(Isa::v3)) {
    out.push_back(named(hover_loops_v3().single, "one by one, v3"));
    out.push_back(named(hover_loops_v3().four, "4 lanes, v3"));
  }
  if (machine_has(Isa::v4)) {
    out.push_back(named(hover_loops_v4().single, "one by one, v4"));
    out.push_back(named(hover_loops_v4().four, "4 lanes, v4"));
    out.push_back(named(hover_loops_v4().eight, "8 lanes, v4"));
  }
  return out;
}

}  // namespace skybody::bench::limit
