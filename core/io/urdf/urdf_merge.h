// Merges links on fixed joints into groups. Internal to core/io's URDF reader.
#pragma once

#include <vector>

#include "core/io/urdf/urdf_links_and_joints.h"
#include "core/io/yaml/diagnostics.h"
#include "core/model/model_marks.h"

namespace skybody {

/// Links that move as one piece. The group's frame is the frame of its first link, the only link on
/// a movable joint.
struct UrdfGroup {
  int joint = -1;             ///< URDF joint that moves the group; -1: the root of a free robot
  int parent = -1;            ///< group index; -1: the world
  std::vector<int> links;     ///< in the order of the tree, the group's own link first
  std::vector<int> children;  ///< indices of groups whose parent is this one
  MassProperties mass;        ///< of all links, in the group's frame
  std::vector<Shape> collisions;
  std::vector<Shape> visuals;
  BodyMarks marks;

  bool is_massless() const { return mass.mass == 0.0; }
  bool has_shapes() const { return !collisions.empty() || !visuals.empty(); }
};

/// The groups of a document, parents before children.
struct UrdfGroups {
  std::vector<UrdfGroup> groups;
  std::vector<Pose> link_pose;  ///< per link: its frame in its group's frame
  std::vector<int> link_group;  ///< per link; -1: in no group, such as the link `world`
};

/// Merges links exactly (parallel axes, rotations).
/// - Warnings: merged massless links, and links with invalid inertias in bodies with valid ones.
/// - Errors: bodies with invalid inertias, and mass on the root link `world`.
/// @param repair_inertia  repair invalid inertias (repaired_inertia()), with a warning
UrdfGroups merge_fixed_joints(const UrdfDocument& document, bool repair_inertia,
                              Diagnostics& diagnostics);

/// The combined mass properties of several bodies given in one frame. Exact for a single one.
MassProperties add_masses(const std::vector<MassProperties>& parts);

}  // namespace skybody
