// The random worlds that tree_flights flies; together they cover every part of the tree engine.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/physics/world/lane_state.h"
#include "core/physics/world/world.h"

namespace skybody::test {

/// A world, and the initial values of a group's lanes.
struct FlownWorld {
  std::string name;
  std::unique_ptr<const World> world;
  std::vector<LaneState> lanes;
};

/// The same worlds at every call.
std::vector<FlownWorld> make_flown_worlds();

}  // namespace skybody::test
