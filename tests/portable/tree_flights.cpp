// Flies random worlds on the tree engine, draws random scenes, and prints a hash of each result.
// Every instruction set and processor must give the same bits; tests/golden/trees.txt pins them.
//
//   tree_flights                 one line per world: its name, a hash of the motion of all lanes;
//                                then one per scene: its name, a hash of its images
//   tree_flights --compare FILE  compares these lines with the file's, on every instruction set
//
// SKYBODY_ISA restricts the second command to one set; the first command uses that set, or the
// highest. Each world is flown in packs and lane by lane. Exit status 0: as pinned, 1: some hashes
// differ, 2: any other error.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "core/base/math/hash.h"
#include "core/base/simd/fp_environment.h"
#include "core/base/simd/isa.h"
#include "core/base/system/error.h"
#include "tests/portable/drawn_scenes.h"
#include "tests/portable/flown_worlds.h"
#include "tests/unit/physics/lane_groups.h"

namespace skybody::test {
namespace {

constexpr int kSteps = 20;

void add(HashChain& chain, double value) { chain.update(canonical_nan(bit_cast_word(value))); }

// Adds the state that a step changes (kStateBlocks) and the bodies, lane by lane: the same words in
// both forms.
void add_lanes(HashChain& chain, PackGroup& packs) {
  const auto add_lane = [&](const AlignedArray<double>& values, int lane) {
    for (auto k = static_cast<std::size_t>(lane); k < values.size(); k += kGroupLanes) {
      add(chain, values[k]);
    }
  };
  for (int lane = 0; lane < kGroupLanes; ++lane) {
    for (const StateBlock& b : kStateBlocks) add_lane(packs.values_at(b.place), lane);
    add_lane(packs.bodies, lane);
  }
}
void add_lanes(HashChain& chain, Alone& alone) {
  for (LaneState& state : alone.states) {
    for (const StateBlock& b : kStateBlocks) {
      for (const double value : values_of(state, b.place)) add(chain, value);
    }
    const auto* bodies = reinterpret_cast<const double*>(state.bodies.data());
    for (std::size_t k = 0; k < 13 * state.bodies.size(); ++k) add(chain, bodies[k]);
  }
}

/// @param group  PackGroup, or Alone
/// @returns a hash over all steps; in some steps only a part of the lanes steps
template <class Group>
std::string fly(Group& group, const FlownWorld& flown) {
  for (int lane = 0; lane < kGroupLanes; ++lane) {
    group.set(lane, flown.lanes[static_cast<std::size_t>(lane)]);
  }
  group.refresh(kAllLanes);
  HashChain chain;
  std::uint32_t lanes = kAllLanes;
  for (int step = 0; step < kSteps; ++step) {
    const std::uint32_t some = step % 5 == 4 ? lanes & kSomeLanes : lanes;
    lanes &= ~(some & ~group.advance(some));  // failed lanes keep their state
    chain.update(lanes);
    add_lanes(chain, group);
  }
  return to_hex(chain.value());
}

std::string fly_both_ways(const FlownWorld& flown) {
  const GroupPhysics physics(*flown.world);
  PackGroup packs(*flown.world, physics);
  Alone alone(*flown.world);
  const std::string in_packs = fly(packs, flown), one_by_one = fly(alone, flown);
  SKYBODY_DEMAND(in_packs == one_by_one,
                 flown.name + " is " + in_packs + " in packs, but " + one_by_one + " lane by lane");
  return in_packs;
}

/// The name of a world or a scene, and the hash of its flight or its images.
struct Line {
  std::string name, hash;
};

std::vector<Line> fly_all() {
  std::vector<Line> lines;
  for (const FlownWorld& flown : make_flown_worlds()) {
    lines.push_back({flown.name, fly_both_ways(flown)});
  }
  for (const DrawnScene& drawn : draw_scenes()) lines.push_back({drawn.name, drawn.hash});
  return lines;
}

std::map<std::string, std::string> read_pinned(const std::string& file) {
  std::ifstream in(file);
  std::map<std::string, std::string> pinned;
  for (Line line; in >> line.name >> line.hash;) pinned[line.name] = line.hash;
  if (pinned.empty()) {
    throw Error(file + " has no lines of a name and a hash; tests/golden/golden.py --write " +
                "makes tests/golden/trees.txt");
  }
  return pinned;
}

/// @returns true if every hash is as pinned; prints the differences
bool compare(Isa isa, std::map<std::string, std::string> pinned) {
  setenv("SKYBODY_ISA", name(isa), 1);
  int moved = 0, flown = 0;
  for (const Line& line : fly_all()) {
    ++flown;
    const auto found = pinned.find(line.name);
    const std::string before = found == pinned.end() ? "not pinned" : found->second;
    if (found != pinned.end()) pinned.erase(found);
    if (before == line.hash) continue;
    ++moved;
    std::printf("%s, %s: %s -> %s\n", name(isa), line.name.c_str(), before.c_str(),
                line.hash.c_str());
  }
  for (const auto& left : pinned) {
    ++moved;
    std::printf("%s, %s: no longer flown\n", name(isa), left.first.c_str());
  }
  if (moved == 0) std::printf("%s: %d hashes as pinned\n", name(isa), flown);
  return moved == 0;
}

/// Compares on the set that SKYBODY_ISA names, or on all sets that the machine has.
bool compare_all(const std::string& file) {
  const auto pinned = read_pinned(file);
  const char* wanted = std::getenv("SKYBODY_ISA");
  if (wanted != nullptr && *wanted != '\0') return compare(best_isa(), pinned);
  bool same = true;
  for (const Isa isa : kIsas) {
    if (machine_has(isa)) same &= compare(isa, pinned);
  }
  return same;
}

int run(const std::vector<std::string>& arguments) {
  const FpEnvironment standard;
  if (fp_probe() != kFpProbeExpected) {
    throw Error("compiled with flags that change bits, such as -ffast-math or -ffp-contract=fast");
  }
  if (arguments.empty()) {
    for (const Line& line : fly_all()) std::printf("%s %s\n", line.name.c_str(), line.hash.c_str());
    return 0;
  }
  if (arguments.size() == 2 && arguments[0] == "--compare") {
    return compare_all(arguments[1]) ? 0 : 1;
  }
  throw Error("it takes nothing, or --compare FILE");
}

}  // namespace
}  // namespace skybody::test

int main(int argc, char** argv) {
  try {
    return skybody::test::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tree_flights: %s\n", error.what());
    return 2;
  }
}
