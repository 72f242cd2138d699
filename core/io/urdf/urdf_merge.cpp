#include "core/io/urdf/urdf_merge.h"

#include <cstdio>

#include "core/base/math/inertia.h"
#include "core/io/files/text.h"
#include "core/io/yaml/pose.h"

namespace skybody {
namespace {

std::string inertia_text(const SymMat3<double>& i) {
  const auto number = [](double value) { return format_number(value); };
  return "ixx=" + number(i.xx) + " ixy=" + number(i.xy) + " ixz=" + number(i.xz) +
         " iyy=" + number(i.yy) + " iyz=" + number(i.yz) + " izz=" + number(i.zz);
}

/// Formats with six digits; further digits are round-off of the solver.
std::string moments_text(const Vec3<double>& moments) {
  char text[80];
  std::snprintf(text, sizeof(text), "[%.6g, %.6g, %.6g]", moments.x, moments.y, moments.z);
  return text;
}

/// The violated rule of the moments, with its bound: "izz must not exceed ixx + iyy, 0.08".
std::string bound_text(const SymMat3<double>& i) {
  const Vec3<double> p = eigenvalues(i);
  if (!(p.x > 0.0)) return "all must be above 0";
  const auto rule = [](const std::string& largest, const std::string& others, double bound) {
    char number[32];
    std::snprintf(number, sizeof(number), "%.6g", bound);
    return largest + " must not exceed " + others + ", " + number;
  };
  if (i.xy != 0.0 || i.xz != 0.0 || i.yz != 0.0) {
    return rule("the largest", "the sum of the other two", p.x + p.y);
  }
  if (i.zz >= i.xx && i.zz >= i.yy) return rule("izz", "ixx + iyy", i.xx + i.yy);
  if (i.yy >= i.xx) return rule("iyy", "ixx + izz", i.xx + i.zz);
  return rule("ixx", "iyy + izz", i.yy + i.zz);
}

bool is_zero(const SymMat3<double>& i) {
  return i.xx == 0.0 && i.yy == 0.0 && i.zz == 0.0 && i.xy == 0.0 && i.xz == 0.0 && i.yz == 0.0;
}

class Merger {
 public:
  Merger(const UrdfDocument& document, bool repair_inertia, Diagnostics& diagnostics)
      : document_(document), repairs_(repair_inertia), diagnostics_(diagnostics) {
    result_.link_pose.resize(document.links.size());
    result_.link_group.assign(document.links.size(), -1);
  }

  UrdfGroups run() {
    const UrdfLink& root = document_.links[static_cast<std::size_t>(document_.root)];
    if (root.name == "world") {
      check_world(root);
      check_free_base(root);
      open_groups(root.child_joints, -1);
    } else {
      open_groups({-1}, -1);
    }
    for (UrdfGroup& group : result_.groups) finish(group);
    return std::move(result_);
  }

 private:
  const UrdfLink& link(int index) const { return document_.links[static_cast<std::size_t>(index)]; }
  const UrdfJoint& joint(int index) const {
    return document_.joints[static_cast<std::size_t>(index)];
  }

  void check_world(const UrdfLink& world) {
    const SourceLocation mark = world.mark;
    if (world.has_inertial && !world.is_massless()) {
      diagnostics_.error(mark,
                         "the root link `world` stands for the world and can have no mass; "
                         "rename it, or remove its <inertial>");
    }
    if (!world.collisions.empty() || !world.visuals.empty()) {
      diagnostics_.warning(mark, "the shapes of the link `world` are ignored; use `obstacles`");
    }
  }

  /// A robot has one base: a floating joint must be the only joint on the link `world`.
  void check_free_base(const UrdfLink& world) {
    if (world.child_joints.size() < 2) return;
    for (int index : world.child_joints) {
      const UrdfJoint& floating = joint(index);
      if (floating.type != UrdfJointType::kFloating) continue;
      diagnostics_.error(floating.mark,
                         "the joint `" + floating.name + "` lets `" + link(floating.child).name +
                             "` float, but it is not the only joint on the link `world`; make "
                             "what else hangs on `world` a robot or an obstacle of its own");
    }
  }

  /// Opens the groups moved by `joints` (-1: the free root) and all groups on them: parents first,
  /// otherwise in the order of the file. Uses an explicit stack: chains may have thousands of
  /// joints.
  void open_groups(const std::vector<int>& joints, int parent) {
    struct Waiting {
      int joint;
      int parent;
    };
    std::vector<Waiting> stack;
    const auto push = [&](const std::vector<int>& list, int group) {
      for (auto it = list.rbegin(); it != list.rend(); ++it) stack.push_back({*it, group});
    };
    push(joints, parent);
    while (!stack.empty()) {
      const Waiting next = stack.back();
      stack.pop_back();
      const int group = open_group(next.joint, next.parent);
      push(take_links(next.joint < 0 ? document_.root : joint(next.joint).child, group), group);
    }
  }

  int open_group(int joint_index, int parent) {
    const int index = static_cast<int>(result_.groups.size());
    UrdfGroup group;
    group.joint = joint_index;
    group.parent = parent;
    result_.groups.push_back(group);
    if (parent >= 0) result_.groups[static_cast<std::size_t>(parent)].children.push_back(index);
    return index;
  }

  /// Adds a link and the links fixed to it to `group`; returns the moving joints on them.
  std::vector<int> take_links(int first_link, int group) {
    struct Branch {
      int link;
      std::size_t next = 0;  ///< index of the link's next joint
    };
    std::vector<int> moving;
    std::vector<Branch> path = {{first_link}};
    place_link(first_link, Pose{}, group);
    while (!path.empty()) {
      Branch& branch = path.back();
      const std::vector<int>& joints = link(branch.link).child_joints;
      if (branch.next == joints.size()) {
        path.pop_back();
        continue;
      }
      const int index = joints[branch.next++];
      const UrdfJoint& child = joint(index);
      if (child.type != UrdfJointType::kFixed) {
        moving.push_back(index);
        continue;
      }
      const Pose& pose = result_.link_pose[static_cast<std::size_t>(branch.link)];
      place_link(child.child, compose(pose, child.origin), group);
      path.push_back({child.child});
    }
    return moving;
  }

  void place_link(int link_index, const Pose& pose, int group) {
    result_.link_pose[static_cast<std::size_t>(link_index)] = pose;
    result_.link_group[static_cast<std::size_t>(link_index)] = group;
    result_.groups[static_cast<std::size_t>(group)].links.push_back(link_index);
  }

  void finish(UrdfGroup& group) {
    std::vector<MassProperties> parts;
    for (int index : group.links) {
      const UrdfLink& source = link(index);
      const Pose& pose = result_.link_pose[static_cast<std::size_t>(index)];
      if (!source.is_massless()) parts.push_back(transform(pose, mass_of(source, group)));
      if (source.is_massless() && index != group.links[0]) warn_massless(source);
      if (source.is_massless() && !is_zero(source.mass.inertia)) warn_lone_inertia(source);
      for (const Shape& shape : source.collisions) group.collisions.push_back(place(shape, pose));
      for (const Shape& shape : source.visuals) group.visuals.push_back(place(shape, pose));
    }
    group.mass = add_masses(parts);
    note_marks(group);
    if (group.is_massless()) return;
    if (repairs_ && !is_physical_inertia(group.mass.inertia)) {
      const UrdfLink& source = link(group.links[0]);
      group.mass.inertia = repaired(body_of(source), source, group.mass);
    }
    check_inertia(group);
  }

  void note_marks(UrdfGroup& group) const {
    double heaviest = -1.0;
    for (int index : group.links) {
      const UrdfLink& source = link(index);
      std::vector<SourceLocation>& shapes = group.marks.collisions;
      shapes.insert(shapes.end(), source.collision_marks.begin(), source.collision_marks.end());
      if (source.mass.mass <= heaviest) continue;
      heaviest = source.mass.mass;
      group.marks.mass = source.mass_mark;
      group.marks.inertia = source.inertia_mark;
    }
  }

  static std::string body_of(const UrdfLink& source) {
    return "the body of the link `" + source.name + "` (links on fixed joints merged)";
  }

  /// Whether a merged link without inertia counts as a point mass.
  static bool is_point(const UrdfLink& source, const UrdfGroup& group) {
    return group.links.size() > 1 && is_zero(source.mass.inertia);
  }

  MassProperties mass_of(const UrdfLink& source, const UrdfGroup& group) {
    MassProperties mass = source.mass;
    if (repairs_ && !is_point(source, group) && !is_physical_inertia(mass.inertia)) {
      mass.inertia = repaired("the link `" + source.name + "`", source, mass);
    }
    return mass;
  }

  SymMat3<double> repaired(const std::string& what, const UrdfLink& source,
                           const MassProperties& mass) {
    const SymMat3<double> mended = repaired_inertia(mass.inertia, mass.mass);
    diagnostics_.warning(source.inertia_mark,
                         "`inertia: repair` gives " + what + " the principal moments " +
                             moments_text(eigenvalues(mended)) + " kg m^2; written are " +
                             moments_text(eigenvalues(mass.inertia)));
    return mended;
  }

  static Shape place(Shape shape, const Pose& pose) {
    shape.pose = compose(pose, shape.pose);
    return shape;
  }

  void warn_massless(const UrdfLink& source) {
    const UrdfJoint& by = joint(source.parent_joint);
    diagnostics_.warning(source.mark, "the link `" + source.name +
                                          "` has no mass; it merges with `" + link(by.parent).name +
                                          "` through the fixed joint `" + by.name + "`");
  }

  void warn_lone_inertia(const UrdfLink& source) {
    diagnostics_.warning(source.inertia_mark, "the link `" + source.name + "` has an inertia (" +
                                                  inertia_text(source.mass.inertia) +
                                                  ") and no mass; the inertia is ignored");
  }

  /// Moving bodies must be physically valid. An invalid link in a valid body changes only the
  /// body's values: a warning.
  void check_inertia(const UrdfGroup& group) {
    const bool good = is_physical_inertia(group.mass.inertia);
    if (good && repairs_) return;
    bool named = false;
    for (int index : group.links) {
      const UrdfLink& source = link(index);
      const SymMat3<double>& inertia = source.mass.inertia;
      if (source.is_massless() || is_point(source, group) || is_physical_inertia(inertia)) continue;
      not_physical("the link `" + source.name + "`", source, inertia, good);
      named = true;
    }
    if (good || named) return;
    const UrdfLink& source = link(group.links[0]);
    not_physical(body_of(source), source, group.mass.inertia, false);
  }

  void not_physical(const std::string& what, const UrdfLink& source, const SymMat3<double>& inertia,
                    bool only_warn) {
    const std::string message = "no rigid body has the inertia of " + what + ", " +
                                inertia_text(inertia) + ": its principal moments are " +
                                moments_text(eigenvalues(inertia)) + " kg m^2; " +
                                bound_text(inertia);
    const SourceLocation& mark = source.inertia_mark;
    if (only_warn) {
      diagnostics_.warning(mark, message + " (the body that it merges into is sound)");
    } else {
      diagnostics_.error(mark, message + "; `inertia: repair` of the robot mends it");
    }
  }

  const UrdfDocument& document_;
  bool repairs_;
  Diagnostics& diagnostics_;
  UrdfGroups result_;
};

}  // namespace

MassProperties add_masses(const std::vector<MassProperties>& parts) {
  if (parts.size() == 1) return parts[0];
  MassProperties total;
  Vec3<double> moment{0.0, 0.0, 0.0};
  for (const MassProperties& part : parts) {
    total.mass += part.mass;
    moment += part.com * part.mass;
  }
  if (total.mass == 0.0) return total;
  total.com = moment / total.mass;
  for (const MassProperties& part : parts) {
    total.inertia = total.inertia + part.inertia + point_inertia(part.mass, part.com - total.com);
  }
  return total;
}

UrdfGroups merge_fixed_joints(const UrdfDocument& document, bool repair_inertia,
                              Diagnostics& diagnostics) {
  return Merger(document, repair_inertia, diagnostics).run();
}

}  // namespace skybody
