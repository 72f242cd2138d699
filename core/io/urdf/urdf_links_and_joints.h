// A URDF after parsing and before merging: links and joints as in the file, checked one by one,
// each with its location. Internal to core/io's URDF reader.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/io/yaml/diagnostics.h"
#include "core/model/robot_model.h"

namespace skybody {

enum class UrdfJointType { kFixed, kRevolute, kContinuous, kPrismatic, kFloating };

struct UrdfLink {
  std::string name;
  SourceLocation mark;
  SourceLocation mass_mark, inertia_mark;
  bool has_inertial = false;
  MassProperties mass;            ///< com and inertia in the link's frame
  std::vector<Shape> collisions;  ///< poses in the link's frame
  std::vector<Shape> visuals;     ///< poses in the link's frame
  std::vector<SourceLocation> collision_marks;
  int parent_joint = -1;
  std::vector<int> child_joints;  ///< in the order of the file

  bool is_massless() const { return mass.mass == 0.0; }
};

struct UrdfJoint {
  std::string name;
  SourceLocation mark;
  UrdfJointType type = UrdfJointType::kFixed;
  int parent = 0;  ///< link index
  int child = 0;   ///< link index
  Pose origin;     ///< joint frame in the parent link's frame; equals the child's frame at zero
  Vec3<double> axis{1.0, 0.0, 0.0};  ///< unit, in the joint frame
  bool limited = false;
  double lower = 0.0;  ///< [rad] or [m]
  double upper = 0.0;
  double damping = 0.0;
  SourceLocation damping_mark;

  bool turns() const {
    return type == UrdfJointType::kRevolute || type == UrdfJointType::kContinuous;
  }
};

struct UrdfDocument {
  std::string name;
  std::string file;
  std::vector<UrdfLink> links;
  std::vector<UrdfJoint> joints;
  int root = 0;  ///< link index
};

/// Parses the text of a URDF. tinyxml2 supplies elements with locations and checks, urdfdom the
/// semantics, core/base the rotations. Returns nullopt and errors for invalid files.
std::optional<UrdfDocument> parse_urdf_document(const std::string& text, const std::string& file,
                                                Diagnostics& diagnostics);

}  // namespace skybody
