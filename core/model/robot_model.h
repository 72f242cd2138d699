// One robot as data: a tree of bodies, rotors, shapes. core/io reads it from URDF and rotors.yaml
// and validates it; afterwards it never changes. C++17, no Simbody, no YAML.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/math/mat3.h"
#include "core/base/math/quat.h"
#include "core/base/math/vec3.h"
#include "core/model/constants.h"
#include "core/model/height_field.h"
#include "core/model/triangle_mesh.h"

namespace skybody {

struct ModelMarks;

/// A rigid transform: `rotation` maps vectors of the inner frame to the outer frame, `position` is
/// the inner frame's origin in the outer frame [m].
struct Pose {
  Vec3<double> position{0.0, 0.0, 0.0};
  Quat<double> rotation{1.0, 0.0, 0.0, 0.0};
};

/// Mass properties of one body, in the body's own frame B.
struct MassProperties {
  double mass = 0.0;                ///< [kg], > 0 (0 only for a link that merges)
  Vec3<double> com{0.0, 0.0, 0.0};  ///< centre of mass in B [m]
  SymMat3<double> inertia{0.0, 0.0, 0.0,
                          0.0, 0.0, 0.0};  ///< about the centre of mass, B axes [kg m^2]
};

/// The same values in the order of kBodyConstants, and the inverse.
std::array<double, kBodyParamCount> body_constants(const MassProperties& mass);
MassProperties mass_properties(const double* constants);

/// The motion of a body relative to its parent. F is the joint's frame on the parent, M the one on
/// the body; q and u below are the coordinates of M in F, in this order.
enum class JointType {
  kWeld,       ///< none: a fixed base, welded to the world
  kFree,       ///< q = position of M in F (3, m), quaternion F from M (4, w x y z);
               ///< u = velocity of M's origin in F (3, m/s), angular velocity in M axes (3, rad/s)
  kPin,        ///< q = angle about z of F = z of M (rad); u = its rate
  kSlider,     ///< q = travel along x of F = x of M (m); u = its rate
  kUniversal,  ///< q = angle about x of F, then about y of M (rad, rad); u = their rates
  kBall,       ///< q = quaternion F from M (4, w x y z); u = angular velocity of M in F, M axes (3)
};

/// Number of position coordinates of a joint (quaternions count four). Inline for kernels: a
/// function call would spill their registers.
constexpr int position_size(JointType type) {
  constexpr int kSizes[] = {0, 7, 1, 1, 2, 4};  // in the order of JointType
  return kSizes[static_cast<int>(type)];
}
/// Number of velocity coordinates of a joint.
constexpr int velocity_size(JointType type) {
  constexpr int kSizes[] = {0, 6, 1, 1, 2, 3};
  return kSizes[static_cast<int>(type)];
}

/// A travel limit of a pin or slider joint: a one-sided spring and damper beyond the bounds
/// (kLimitStiffness, kLimitDamping).
struct JointLimit {
  bool enabled = false;
  double lower = 0.0;  ///< [rad] or [m]
  double upper = 0.0;  ///< [rad] or [m], > lower
};

/// The inboard joint of a body.
struct Joint {
  std::string name;
  JointType type = JointType::kFree;
  int parent = -1;        ///< body index in the same robot; -1: the world
  Pose frame_in_parent;   ///< X_PF: joint frame F in the parent body's frame; free base: identity
  double position = 0.0;  ///< pin and slider: position at a reset [rad] or [m]
  Pose frame_in_body;     ///< X_BM: joint frame M in this body's frame; free base: identity
  std::array<double, kJointParamCount> constants{};  ///< values of kJointConstants
  JointLimit limit;
};

/// Number of kJointConstants that apply to a joint, counted from the first:
/// - weld or free base: none
/// - ball and universal joints: damping
/// - pins and sliders: damping and the spring; with limits: all
int joint_constant_count(const Joint& joint);

/// Whether the joint moves a body relative to another one: neither a weld nor a free base.
inline bool is_moving_joint(const Joint& joint) {
  return joint.type != JointType::kWeld && !(joint.type == JointType::kFree && joint.parent < 0);
}

enum class ShapeType { kBox, kCylinder, kSphere, kMesh, kCapsule, kPlane, kHeightField };

/// A collision or visual shape, placed in the frame of its body.
struct Shape {
  ShapeType type = ShapeType::kSphere;
  Pose pose;                         ///< shape frame in the body's frame
  Vec3<double> size{0.0, 0.0, 0.0};  ///< box: edge lengths; height field: along x and y [m]; mesh:
                                     ///< scale factors
  double radius = 0.0;               ///< cylinder, sphere, capsule [m]
  double length = 0.0;  ///< along z of the shape [m]; cylinder: its length; capsule: between the
                        ///< centres of its caps
  Vec3<double> box_size{0.0, 0.0, 0.0};    ///< collision mesh: edge lengths of its scaled bounding
                                           ///< box, along the shape's axes [m]
  Vec3<double> box_center{0.0, 0.0, 0.0};  ///< centre of that box in the shape's frame [m]
  std::shared_ptr<const HeightField> heights;  ///< height field
  std::string mesh;                            ///< mesh: file name from the URDF
  std::string mesh_file;                       ///< mesh: its path
  /// Mesh of a format that is read: reads its triangles. @returns the problem, or ""
  std::function<std::string(TriangleMesh&)> read_triangles;
  std::array<double, 4> rgba{0.5, 0.5, 0.5, 1.0};  ///< visual colour, each in [0, 1]
  std::string texture_file;                        ///< visual: path of the picture on it, or ""
};

/// The shape used for contact: the shape itself, or a mesh's bounding box.
Shape contact_shape(const Shape& shape);

/// Whether a shape's solid extends down without limit: no penetration passes through it.
constexpr bool is_unbounded_below(ShapeType type) {
  return type == ShapeType::kPlane || type == ShapeType::kHeightField;
}

/// A link of the URDF. Links on fixed joints share the body that they were merged into.
struct Link {
  std::string name;
  int body = 0;                     ///< index into RobotModel::bodies
  Pose pose;                        ///< link frame in the body's frame
  Vec3<double> com{0.0, 0.0, 0.0};  ///< the link's own centre of mass in the body's frame [m]
};

/// One rigid body: all links that move as one piece. Body 0 is the base.
struct Body {
  std::string name;  ///< name of the link whose frame is the body's frame
  Joint joint;       ///< inboard joint
  MassProperties mass;
  std::vector<Shape> collisions;
  std::vector<Shape> visuals;
};

/// One rotor with its nominal constants.
struct Rotor {
  std::string name;
  int body = 0;                      ///< index into RobotModel::bodies
  Vec3<double> axis{0.0, 0.0, 1.0};  ///< thrust direction in the body's frame, unit
  int direction = 1;                 ///< +1: turns counter-clockwise about `axis`; -1: clockwise
  double min_speed = 0.0;            ///< [rad/s]; below 0: it also turns backwards (is_reversible)
  std::array<double, kRotorParamCount> constants{};  ///< values of kRotorConstants

  /// Whether it can turn backwards, with thrust against `axis`.
  bool is_reversible() const { return min_speed < 0.0; }
  /// Hub in the body's frame [m].
  Vec3<double> position() const {
    const double* p = &constants[kRotorPosition];
    return {p[0], p[1], p[2]};
  }
  void set_position(const Vec3<double>& hub) {
    double* p = &constants[kRotorPosition];
    p[0] = hub.x;
    p[1] = hub.y;
    p[2] = hub.z;
  }
};

/// A robot. Parent bodies precede their children.
struct RobotModel {
  std::string name;
  std::string urdf_file;    ///< its source, for messages and logs
  bool fixed_base = false;  ///< the base, body 0, is not free: its joint is not kFree
  std::vector<Body> bodies;
  std::vector<Link> links;
  std::vector<Rotor> rotors;
  std::shared_ptr<const ModelMarks> marks;  ///< locations in its files; null: not from files

  /// Sum of the bodies' nominal masses [kg].
  double total_mass() const;
  /// Index of the link called `link_name`, or -1.
  int find_link(const std::string& link_name) const;
};

}  // namespace skybody
