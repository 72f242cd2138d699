#include "core/io/urdf_joints.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/mat3.h"
#include "core/io/pose.h"

namespace skybody {
namespace {

constexpr double kSameOrigin = 1e-6;   // [m]
constexpr double kOrthogonal = 1e-4;   // cosine of the angle between axes; rounded rpy stays below
constexpr double kFullTurn = 6.28318;  // [rad]; limits at least this wide do not limit

/// The shortest rotation that takes `from` to `to`, both unit. Only sqrt.
Quat<double> shortest_rotation(const Vec3<double>& from, const Vec3<double>& to) {
  const double cosine = dot(from, to);
  if (cosine > -1.0 + 1e-12) {
    const Vec3<double> axis = cross(from, to);
    return normalized(Quat<double>{1.0 + cosine, axis.x, axis.y, axis.z});
  }
  // Half a turn about any axis across `from`.
  const Vec3<double> helper =
      std::fabs(from.x) < 0.9 ? Vec3<double>{1, 0, 0} : Vec3<double>{0, 1, 0};
  const Vec3<double> axis = cross(from, helper);
  return normalized(Quat<double>{0.0, axis.x, axis.y, axis.z});
}

/// The frame with x along `x` and y as close to `y` as can be.
Quat<double> frame_of_axes(const Vec3<double>& x, const Vec3<double>& y) {
  const Vec3<double> across = y - x * dot(x, y);
  const Vec3<double> second = across / norm(across);
  const Vec3<double> third = cross(x, second);
  return from_rotation(
      Mat3<double>{{x.x, second.x, third.x, x.y, second.y, third.y, x.z, second.z, third.z}});
}

bool limits_matter(const UrdfJoint& joint) {
  return joint.limited && joint.upper - joint.lower < kFullTurn;
}

class BodyMaker {
 public:
  BodyMaker(const UrdfDocument& document, const UrdfGroups& groups, RobotModel& model,
            Diagnostics& diagnostics)
      : document_(document), groups_(groups), model_(model), diagnostics_(diagnostics) {
    body_of_group_.assign(groups.groups.size(), -1);
  }

  void run(bool fixed_base) {
    for (std::size_t g = 0; g < groups_.groups.size(); ++g) {
      const UrdfGroup& group = groups_.groups[g];
      if (is_base(group, fixed_base)) {
        add_base(static_cast<int>(g), fixed_base);
      } else if (group.is_massless()) {
        check_massless(group);
      } else {
        add_moving(static_cast<int>(g));
      }
    }
    add_links();
  }

 private:
  const UrdfGroup& group(int index) const {
    return groups_.groups[static_cast<std::size_t>(index)];
  }
  const UrdfLink& link(int index) const { return document_.links[static_cast<std::size_t>(index)]; }
  const UrdfJoint& joint_of(const UrdfGroup& group) const {
    return document_.joints[static_cast<std::size_t>(group.joint)];
  }
  const UrdfLink& first_link(const UrdfGroup& group) const { return link(group.links[0]); }

  void error(int line, const std::string& message) {
    diagnostics_.error(document_.mark(line), message);
  }

  /// The root of a robot, or what stands on the link `world`; there `fixed_base` holds what floats.
  bool is_base(const UrdfGroup& group, bool fixed_base) const {
    if (group.joint < 0) return true;
    const UrdfJointType type = joint_of(group).type;
    return type == UrdfJointType::kFixed ||
           (type == UrdfJointType::kFloating && group.parent < 0 && fixed_base);
  }

  /// The joint frame (at zero) in the frame of the group that carries it.
  Pose joint_frame(const UrdfJoint& joint) const {
    return compose(groups_.link_pose[static_cast<std::size_t>(joint.parent)], joint.origin);
  }

  void push_body(int g, Joint joint) {
    const UrdfGroup& source = group(g);
    Body body;
    body.name = first_link(source).name;
    body.joint = std::move(joint);
    body.mass = source.mass;
    body.collisions = source.collisions;
    body.visuals = source.visuals;
    body_of_group_[static_cast<std::size_t>(g)] = static_cast<int>(model_.bodies.size());
    model_.bodies.push_back(std::move(body));
  }

  /// The root, or what is welded to the link `world`.
  void add_base(int g, bool fixed_base) {
    const UrdfGroup& source = group(g);
    Joint joint;
    joint.name = source.joint < 0 ? "base" : joint_of(source).name;
    joint.type = source.joint >= 0 || fixed_base ? JointType::kWeld : JointType::kFree;
    if (source.joint >= 0) joint.frame_in_parent = joint_frame(joint_of(source));
    if (joint.type == JointType::kFree && source.is_massless()) {
      const UrdfLink& root = first_link(source);
      error(root.line, "the base `" + root.name +
                           "` has no mass and moves freely; give it an "
                           "<inertial> with a mass, or set fixed_base: true");
    }
    const bool is_welded = joint.type == JointType::kWeld;
    push_body(g, std::move(joint));
    // Simbody wants a mass of every body: one that no sum of masses feels.
    if (is_welded && source.is_massless()) {
      constexpr double kNearlyNone = 1e-9;  // [kg], [kg m^2]
      model_.bodies.back().mass = {
          kNearlyNone, {0.0, 0.0, 0.0}, {kNearlyNone, kNearlyNone, kNearlyNone, 0.0, 0.0, 0.0}};
    }
  }

  /// A moving group without mass is fine only inside a chain, which its child finds.
  void check_massless(const UrdfGroup& source) {
    if (source.children.size() == 1 && !source.has_shapes() && joint_of(source).turns()) return;
    std::string reason;
    if (source.children.empty()) {
      reason = "nothing hangs on it";
    } else if (source.children.size() > 1) {
      reason = std::to_string(source.children.size()) + " moving links hang on it";
    } else {
      reason = source.has_shapes() ? "it has shapes" : "its joint does not turn";
    }
    refuse_massless(source, reason);
  }

  void refuse_massless(const UrdfGroup& source, const std::string& reason) {
    const UrdfLink& bad = first_link(source);
    const std::string what = bad.has_inertial ? "has no mass" : "has no <inertial>";
    error(bad.line, "the link `" + bad.name + "` " + what + " and moves on the joint `" +
                        joint_of(source).name +
                        "`; give it a mass, or fix the joint (no part of a "
                        "universal or ball joint: " +
                        reason + ")");
  }

  /// The groups from the one that hangs on a body to `g`, massless ones in between.
  std::vector<int> chain_to(int g) const {
    std::vector<int> chain = {g};
    int parent = group(g).parent;
    while (parent >= 0 && group(parent).is_massless() && group(parent).joint >= 0 &&
           body_of_group_[static_cast<std::size_t>(parent)] < 0) {
      chain.push_back(parent);
      parent = group(parent).parent;
    }
    std::reverse(chain.begin(), chain.end());
    return chain;
  }

  void add_moving(int g) {
    const std::vector<int> chain = chain_to(g);
    const UrdfJoint& last = joint_of(group(g));
    Joint joint;
    joint.name = last.name;
    joint.constants[kJointDamping] = last.damping;
    const int parent = group(chain[0]).parent;
    joint.parent = parent < 0 ? -1 : body_of_group_[static_cast<std::size_t>(parent)];
    if (chain.size() == 1) {
      set_single(last, joint);
    } else {
      set_chain(chain, joint);
    }
    if (joint.type == JointType::kFree && joint.parent < 0) set_free_base(last, joint);
    push_body(g, std::move(joint));
  }

  void set_single(const UrdfJoint& source, Joint& joint) const {
    Pose axis_frame;
    if (source.type == UrdfJointType::kFloating) {
      joint.type = JointType::kFree;
    } else if (source.turns()) {
      joint.type = JointType::kPin;
      axis_frame.rotation = shortest_rotation({0, 0, 1}, source.axis);
    } else {
      joint.type = JointType::kSlider;
      axis_frame.rotation = shortest_rotation({1, 0, 0}, source.axis);
    }
    joint.frame_in_parent = compose(joint_frame(source), axis_frame);
    joint.frame_in_body = axis_frame;
    joint.limit.enabled = source.limited;
    joint.limit.lower = source.lower;
    joint.limit.upper = source.upper;
  }

  /// The coordinates of a free base are its pose in W, which the scenario gives.
  void set_free_base(const UrdfJoint& source, Joint& joint) {
    if (!is_identity(source.origin)) {
      diagnostics_.warning(document_.mark(source.line),
                           "the <origin> of the floating joint `" + source.name +
                               "` is ignored: the robot's `pose` places its base");
    }
    joint.frame_in_parent = Pose{};
    joint.frame_in_body = Pose{};
  }

  void set_chain(const std::vector<int>& chain, Joint& joint) {
    if (chain.size() > 3) {
      refuse_massless(group(chain[chain.size() - 2]),
                      std::to_string(chain.size()) + " joints follow one another");
      return;
    }
    // Frames and axes of all joints at zero, in the first joint's frame.
    std::vector<Pose> frames = {Pose{}};
    for (std::size_t i = 1; i < chain.size(); ++i) {
      frames.push_back(compose(frames.back(), joint_frame(joint_of(group(chain[i])))));
    }
    std::vector<Vec3<double>> axes;
    for (std::size_t i = 0; i < chain.size(); ++i) {
      axes.push_back(rotate(frames[i].rotation, joint_of(group(chain[i])).axis));
    }
    const std::string problem = chain_problem(chain, frames, axes);
    if (!problem.empty()) {
      refuse_massless(group(chain[chain.size() - 2]), problem);
      return;
    }
    Pose canonical;  // F in the first joint's frame
    joint.type = chain.size() == 2 ? JointType::kUniversal : JointType::kBall;
    if (chain.size() == 2) canonical.rotation = frame_of_axes(axes[0], axes[1]);
    joint.frame_in_parent = compose(joint_frame(joint_of(group(chain[0]))), canonical);
    joint.frame_in_body.rotation = conjugate(frames.back().rotation) * canonical.rotation;
  }

  /// Why the joints of `chain` are not one universal or ball joint, or an empty text.
  std::string chain_problem(const std::vector<int>& chain, const std::vector<Pose>& frames,
                            const std::vector<Vec3<double>>& axes) const {
    const UrdfJoint& last = joint_of(group(chain.back()));
    if (!last.turns()) return "the joint `" + last.name + "` does not turn";
    for (std::size_t i = 0; i < chain.size(); ++i) {
      const UrdfJoint& joint = joint_of(group(chain[i]));
      const UrdfJoint& first = joint_of(group(chain[0]));
      if (norm(frames[i].position) > kSameOrigin) {
        return "the origins of `" + first.name + "` and `" + joint.name + "` differ";
      }
      if (limits_matter(joint)) return "`" + joint.name + "` has limits; make it continuous";
      if (joint.damping != first.damping) {
        return "the damping of `" + first.name + "` and `" + joint.name + "` differs";
      }
      for (std::size_t k = 0; k < i; ++k) {
        if (std::fabs(dot(axes[i], axes[k])) <= kOrthogonal) continue;
        return "the axes of `" + joint_of(group(chain[k])).name + "` and `" + joint.name +
               "` are not orthogonal";
      }
    }
    return "";
  }

  /// Links in the order of the file; those inside universal and ball joints have no body.
  void add_links() {
    for (std::size_t i = 0; i < document_.links.size(); ++i) {
      const int g = groups_.link_group[i];
      const int body = g < 0 ? -1 : body_of_group_[static_cast<std::size_t>(g)];
      if (body < 0) continue;
      const Pose& pose = groups_.link_pose[i];
      model_.links.push_back(
          {document_.links[i].name, body, pose, transform(pose, document_.links[i].mass.com)});
    }
  }

  const UrdfDocument& document_;
  const UrdfGroups& groups_;
  RobotModel& model_;
  Diagnostics& diagnostics_;
  std::vector<int> body_of_group_;
};

}  // namespace

void make_bodies(const UrdfDocument& document, const UrdfGroups& groups, bool fixed_base,
                 RobotModel& model, Diagnostics& diagnostics) {
  BodyMaker(document, groups, model, diagnostics).run(fixed_base);
}

}  // namespace skybody
