#include "core/io/urdf/urdf_bodies.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/math/mat3.h"
#include "core/io/files/text.h"
#include "core/io/yaml/pose.h"

namespace skybody {
namespace {

constexpr double kSameOrigin = 1e-6;   // [m]
constexpr double kOrthogonal = 1e-4;   // cosine of the angle between axes; rounded rpy stays below
constexpr double kFullTurn = 6.28318;  // [rad]; wider limits do not count as limits
constexpr double kParallel = 0.999;    // cosine above which two axes count as parallel
/// Mass and inertia of a massless link, relative to those of its outboard bodies: negligible in
/// measurements, and far above round-off in the sums that contain it.
constexpr double kLightShare = 1e-6;

/// The shortest rotation from `from` to `to`, both unit. Uses only sqrt.
Quat<double> shortest_rotation(const Vec3<double>& from, const Vec3<double>& to) {
  const double cosine = dot(from, to);
  if (cosine > -1.0 + 1e-12) {
    const Vec3<double> axis = cross(from, to);
    return normalized(Quat<double>{1.0 + cosine, axis.x, axis.y, axis.z});
  }
  // Half a turn about any axis perpendicular to `from`.
  const Vec3<double> helper =
      std::fabs(from.x) < 0.9 ? Vec3<double>{1, 0, 0} : Vec3<double>{0, 1, 0};
  const Vec3<double> axis = cross(from, helper);
  return normalized(Quat<double>{0.0, axis.x, axis.y, axis.z});
}

/// The frame with x along `x` and y as close to `y` as possible.
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
  BodyMaker(const UrdfDocument& document, const UrdfGroups& groups, const UrdfOptions& options,
            RobotModel& model, Diagnostics& diagnostics)
      : document_(document),
        groups_(groups),
        options_(options),
        model_(model),
        diagnostics_(diagnostics) {
    body_of_group_.assign(groups.groups.size(), -1);
    why_light_.assign(groups.groups.size(), "");
    outboard_.assign(groups.groups.size(), MassProperties{});
  }

  void run() {
    const auto count = static_cast<int>(groups_.groups.size());
    for (int g = 0; g < count; ++g) find_light(g);
    for (int g = count - 1; g >= 0; --g) sum_outboard(g);
    for (int g = 0; g < count; ++g) {
      if (is_base(group(g), options_.fixed_base)) {
        add_base(g);
      } else if (!group(g).is_massless() || is_light(g)) {
        add_moving(g);
      }
    }
    add_links();
    model_.marks = std::make_shared<const ModelMarks>(std::move(marks_));
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

  void error(const UrdfLink& link, const std::string& message) {
    diagnostics_.error(link.mark, message);
  }

  /// Whether the group is a base: the root, a group fixed to the link `world`, or, with
  /// `fixed_base`, a group on a floating joint of `world`.
  bool is_base(const UrdfGroup& group, bool fixed_base) const {
    if (group.joint < 0) return true;
    const UrdfJointType type = joint_of(group).type;
    return type == UrdfJointType::kFixed ||
           (type == UrdfJointType::kFloating && group.parent < 0 && fixed_base);
  }

  /// The joint frame (at zero) in the frame of the parent group.
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
    marks_.bodies.push_back(source.marks);
    model_.bodies.push_back(std::move(body));
  }

  /// Adds the root, or a group welded to the link `world`.
  void add_base(int g) {
    const bool fixed_base = options_.fixed_base;
    const UrdfGroup& source = group(g);
    Joint joint;
    joint.name = source.joint < 0 ? "base" : joint_of(source).name;
    joint.type = source.joint >= 0 || fixed_base ? JointType::kWeld : JointType::kFree;
    if (source.joint >= 0) joint.frame_in_parent = joint_frame(joint_of(source));
    if (joint.type == JointType::kFree && source.is_massless()) {
      const UrdfLink& root = first_link(source);
      error(root, "the base `" + root.name +
                      "` has no mass and moves freely; give it an "
                      "<inertial> with a mass, or set fixed_base: true");
    }
    const bool is_welded = joint.type == JointType::kWeld;
    push_body(g, std::move(joint));
    // Simbody requires a mass of every body. This one vanishes in every sum of masses.
    if (is_welded && source.is_massless()) {
      constexpr double kNearlyNone = 1e-9;  // [kg], [kg m^2]
      model_.bodies.back().mass = {
          kNearlyNone, {0.0, 0.0, 0.0}, {kNearlyNone, kNearlyNone, kNearlyNone, 0.0, 0.0, 0.0}};
    }
  }

  bool is_light(int g) const { return !why_light_[static_cast<std::size_t>(g)].empty(); }

  /// Whether a group alone qualifies as an inner link of a universal or ball joint.
  bool is_inner(const UrdfGroup& source) const {
    return source.joint >= 0 && source.is_massless() && source.children.size() == 1 &&
           !source.has_shapes() && joint_of(source).turns();
  }

  /// Records why a massless moving group cannot become part of a universal or ball joint.
  void find_light(int g) {
    const UrdfGroup& source = group(g);
    if (source.joint < 0 || is_base(source, options_.fixed_base)) return;
    if (source.is_massless() && !is_inner(source)) {
      std::string& why = why_light_[static_cast<std::size_t>(g)];
      why = source.has_shapes() ? "it has shapes"
            : source.children.size() > 1
                ? std::to_string(source.children.size()) + " moving links hang on it"
                : "its joint does not turn";
    }
    if (is_inner(source)) return;
    const std::vector<int> chain = chain_to(g);
    if (chain.size() == 1) return;
    const std::string problem = chain_problem(chain);
    if (problem.empty()) return;
    for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
      why_light_[static_cast<std::size_t>(chain[i])] = problem;
    }
  }

  /// Sums masses and inertias of each group and its outboard groups, without floating ones. Ignores
  /// positions: light links need only the order of magnitude.
  void sum_outboard(int g) {
    const UrdfGroup& source = group(g);
    MassProperties& sum = outboard_[static_cast<std::size_t>(g)];
    sum.mass += source.mass.mass;
    sum.inertia = sum.inertia + source.mass.inertia;
    const bool floats = source.joint >= 0 && joint_of(source).type == UrdfJointType::kFloating;
    if (source.parent < 0 || floats) return;
    MassProperties& parent = outboard_[static_cast<std::size_t>(source.parent)];
    parent.mass += sum.mass;
    parent.inertia = parent.inertia + sum.inertia;
  }

  MassProperties light_mass(int g) {
    const UrdfLink& bad = first_link(group(g));
    const MassProperties& sum = outboard_[static_cast<std::size_t>(g)];
    const double moment = kLightShare * (sum.inertia.xx + sum.inertia.yy + sum.inertia.zz) / 3.0;
    const MassProperties mass{
        kLightShare * sum.mass, {0.0, 0.0, 0.0}, {moment, moment, moment, 0.0, 0.0, 0.0}};
    diagnostics_.warning(
        bad.mark,
        lack_of(bad) + joint_of(group(g)).name + "`; it gets " + format_number(mass.mass) +
            " kg, a millionth of what hangs on it (no part of a universal or ball joint: " +
            why_light_[static_cast<std::size_t>(g)] + ")");
    return mass;
  }

  static std::string lack_of(const UrdfLink& link) {
    return "the link `" + link.name + "` " +
           (link.has_inertial ? "has no mass" : "has no <inertial>") + " and moves on the joint `";
  }

  void refuse_massless(int g, const std::string& reason) {
    const UrdfLink& bad = first_link(group(g));
    error(bad, lack_of(bad) + joint_of(group(g)).name +
                   "`; give it a mass, or fix the joint: " + reason);
  }

  /// Rejects a light link if it would leave a motion without inertia.
  /// @returns whether it was rejected
  bool refuses_light(int g) {
    if (outboard_[static_cast<std::size_t>(g)].mass == 0.0) {
      refuse_massless(g, "nothing that hangs on it has mass");
      return true;
    }
    if (joint_of(group(g)).type == UrdfJointType::kFloating) {
      refuse_massless(g, "what floats needs a mass of its own");
      return true;
    }
    const std::string same = joint_like(joint_of(group(g)), g, Pose{});
    if (same.empty()) return false;
    refuse_massless(g, "the joint `" + same + "` moves it about the same axis");
    return true;
  }

  /// If two joints share one axis with only light links between them, only the sum of their angles
  /// moves a mass. @returns a joint that moves the same way as `own`, or an empty text
  /// @param frame  frame of the group `g` in the frame moved by `own`
  std::string joint_like(const UrdfJoint& own, int g, const Pose& frame) const {
    for (const int child : group(g).children) {
      const UrdfJoint& next = joint_of(group(child));
      const Pose inner = compose(frame, joint_frame(next));
      const bool is_one_place =
          !own.turns() || norm(cross(inner.position, own.axis)) <= kSameOrigin;
      const double cosine = dot(own.axis, rotate(inner.rotation, next.axis));
      if (next.type != UrdfJointType::kFloating && own.turns() == next.turns() && is_one_place &&
          std::fabs(cosine) >= kParallel) {
        return next.name;
      }
      const std::string further = is_light(child) ? joint_like(own, child, inner) : "";
      if (!further.empty()) return further;
    }
    return "";
  }

  /// The chain of groups from the first one on a body to `g`; all but the last can be merged away.
  std::vector<int> chain_to(int g) const {
    std::vector<int> chain = {g};
    int parent = group(g).parent;
    while (parent >= 0 && is_inner(group(parent)) && !is_light(parent)) {
      chain.push_back(parent);
      parent = group(parent).parent;
    }
    std::reverse(chain.begin(), chain.end());
    return chain;
  }

  void add_moving(int g) {
    if (is_light(g) && refuses_light(g)) return;
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
    marks_.bodies.back().joint[kJointDamping] = last.damping_mark;
    if (is_light(g)) model_.bodies.back().mass = light_mass(g);
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

  /// The coordinates of a free base are its pose in W, set by the scenario.
  void set_free_base(const UrdfJoint& source, Joint& joint) {
    if (!is_identity(source.origin)) {
      diagnostics_.warning(source.mark, "the <origin> of the floating joint `" + source.name +
                                            "` is ignored: the robot's `pose` places its base");
    }
    joint.frame_in_parent = Pose{};
    joint.frame_in_body = Pose{};
  }

  /// Frames of all joints of a chain at zero, in the first joint's frame.
  std::vector<Pose> frames_of(const std::vector<int>& chain) const {
    std::vector<Pose> frames = {Pose{}};
    for (std::size_t i = 1; i < chain.size(); ++i) {
      frames.push_back(compose(frames.back(), joint_frame(joint_of(group(chain[i])))));
    }
    return frames;
  }

  /// Axes of all joints of a chain at zero, in the first joint's frame.
  std::vector<Vec3<double>> axes_of(const std::vector<int>& chain,
                                    const std::vector<Pose>& frames) const {
    std::vector<Vec3<double>> axes;
    for (std::size_t i = 0; i < chain.size(); ++i) {
      axes.push_back(rotate(frames[i].rotation, joint_of(group(chain[i])).axis));
    }
    return axes;
  }

  void set_chain(const std::vector<int>& chain, Joint& joint) const {
    const std::vector<Pose> frames = frames_of(chain);
    const std::vector<Vec3<double>> axes = axes_of(chain, frames);
    Pose canonical;  // F in the first joint's frame
    joint.type = chain.size() == 2 ? JointType::kUniversal : JointType::kBall;
    if (chain.size() == 2) canonical.rotation = frame_of_axes(axes[0], axes[1]);
    joint.frame_in_parent = compose(joint_frame(joint_of(group(chain[0]))), canonical);
    joint.frame_in_body.rotation = conjugate(frames.back().rotation) * canonical.rotation;
  }

  /// The reason why the joints of `chain` do not form one universal or ball joint, or an empty
  /// text.
  std::string chain_problem(const std::vector<int>& chain) const {
    if (chain.size() > 3) return std::to_string(chain.size()) + " joints follow one another";
    const std::vector<Pose> frames = frames_of(chain);
    const std::vector<Vec3<double>> axes = axes_of(chain, frames);
    const UrdfJoint& last = joint_of(group(chain.back()));
    if (!last.turns()) return "the joint `" + last.name + "` does not turn";
    for (std::size_t i = 0; i < chain.size(); ++i) {
      const UrdfJoint& joint = joint_of(group(chain[i]));
      const UrdfJoint& first = joint_of(group(chain[0]));
      if (norm(frames[i].position) > kSameOrigin) {
        return "the origins of `" + first.name + "` and `" + joint.name + "` differ";
      }
      if (limits_matter(joint)) return "`" + joint.name + "` has limits";
      // Only for two joints: three pins in place of a ball joint would have a singular pose.
      if (chain.size() == 2 && options_.own_joints.count(joint.name) > 0) {
        return "the scenario gives `" + joint.name + "` values of its own";
      }
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

  /// Adds links in the order of the file; links inside universal and ball joints have no body.
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
  const UrdfOptions& options_;
  RobotModel& model_;
  Diagnostics& diagnostics_;
  ModelMarks marks_;
  std::vector<int> body_of_group_;
  std::vector<std::string> why_light_;    ///< per group; empty if it has mass or needs none
  std::vector<MassProperties> outboard_;  ///< per group: sum of itself and its outboard groups
};

}  // namespace

void make_bodies(const UrdfDocument& document, const UrdfGroups& groups, const UrdfOptions& options,
                 RobotModel& model, Diagnostics& diagnostics) {
  BodyMaker(document, groups, options, model, diagnostics).run();
}

}  // namespace skybody
