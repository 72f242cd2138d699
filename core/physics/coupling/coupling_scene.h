// The couplings of a world in its numbering: their bodies and their equations. Made once.
#pragma once

#include <array>
#include <vector>

#include "core/physics/world/world.h"

namespace skybody {

/// Attachment point of one end of a coupling.
struct Attachment {
  int body = -1;                      ///< world body index; -1: the world
  int robot = -1;                     ///< world robot index; -1: the world
  Vec3<double> point{0.0, 0.0, 0.0};  ///< in the body's frame, or in W [m]
};

/// A coupling in the world's numbering.
struct CouplingConstraint {
  CouplingKind kind = CouplingKind::kRod;
  std::array<Attachment, 2> ends;
  int params = 0;     ///< first of its constants in the parameter block
  int first_row = 0;  ///< of its equations; a spring has none
  int row_count = 0;
};

/// Immutable; refers to the world, which must outlive it.
struct CouplingScene {
  explicit CouplingScene(const World& world);

  /// Whether robot r has a coupling other than springs.
  bool is_held(int robot) const { return held_with[static_cast<std::size_t>(robot)] >= 0; }

  const World& world;
  std::vector<CouplingConstraint> constraints;  ///< one per coupling of the scenario
  std::vector<int> row_owners;                  ///< per equation: its constraint
  int rope_count = 0;
  std::vector<int> driven;     ///< bodies: driven bases of constrained robots
  std::vector<int> held_with;  ///< per robot: the first robot of its connected group; -1: not
                               ///< constrained
};

}  // namespace skybody
