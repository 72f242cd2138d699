// Links on fixed joints become one group each. Internal to core/io's URDF reader.
#pragma once

#include <vector>

#include "core/io/diagnostics.h"
#include "core/io/urdf_document.h"

namespace skybody {

/// Links that move as a piece. The group's frame is the frame of its first link, the only one whose
/// own joint can move.
struct UrdfGroup {
  int joint = -1;             ///< URDF joint that moves the group; -1: the root of a free robot
  int parent = -1;            ///< group index; -1: the world
  std::vector<int> links;     ///< in the order of the tree, the group's own link first
  std::vector<int> children;  ///< groups on this one
  MassProperties mass;        ///< of all links, in the group's frame
  std::vector<Shape> collisions;
  std::vector<Shape> visuals;

  bool is_massless() const { return mass.mass == 0.0; }
  bool has_shapes() const { return !collisions.empty() || !visuals.empty(); }
};

/// The groups of a document, parents before children.
struct UrdfGroups {
  std::vector<UrdfGroup> groups;
  std::vector<Pose> link_pose;  ///< per link: its frame in its group's frame
  std::vector<int>
      link_group;  ///< per link; -1 for the link `world` and what is fixed nowhere else
};

/// Merges links exactly (parallel axes, rotations). Warns of each massless link that is merged and
/// of inertias that no rigid body has in links whose body is sound nevertheless; errors for bodies
/// that are not, and for mass on the root link `world`.
/// @param repair_inertia  mend inertias that no rigid body has (repaired_inertia()), with a warning
UrdfGroups merge_fixed_joints(const UrdfDocument& document, bool repair_inertia,
                              Diagnostics& diagnostics);

/// Mass properties of several bodies given in one frame, as one. Exact for a single one.
MassProperties add_masses(const std::vector<MassProperties>& parts);

}  // namespace skybody
