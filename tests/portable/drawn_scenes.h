// The random scenes that tree_flights draws: all solids, meshes, shadows, pinholes and rays in all
// directions.
#pragma once

#include <string>
#include <vector>

namespace skybody::test {

/// A scene's name, and a hash of its images: depth, range, instance, class, normal, colours.
struct DrawnScene {
  std::string name, hash;
};

/// The same scenes at every call, drawn on the instruction set of best_isa().
std::vector<DrawnScene> draw_scenes();

}  // namespace skybody::test
