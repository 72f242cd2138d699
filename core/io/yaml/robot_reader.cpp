#include "core/io/yaml/robot_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <unordered_map>

#include "core/base/math/hash.h"
#include "core/base/system/suggestion.h"
#include "core/io/files/file.h"
#include "core/io/files/missing_file.h"
#include "core/io/files/shipped_files.h"
#include "core/io/files/text.h"
#include "core/io/urdf/urdf_reader.h"
#include "core/io/yaml/fold_warnings.h"
#include "core/io/yaml/plugin_use_reader.h"
#include "core/io/yaml/rotors_reader.h"
#include "core/io/yaml/scenario_fields.h"

namespace skybody {
namespace {

/// Largest number of bodies of all robots: building a world of them takes half a second.
constexpr std::size_t kMostBodies = 1000;
/// Largest number of links, shapes and rotors of all robots.
constexpr std::size_t kMostParts = 20'000;

/// Messages of each severity about a URDF before its warnings are folded. Each is compared with all
/// earlier ones, which takes a tenth of a second in total.
constexpr int kMostToFold = 10'000;

constexpr const char* kModelRemedy =
    "give a URDF by its path from this file, or a shipped model such as `qdrone2`";

/// Joints with keys in the scenario that universal and ball joints do not support.
std::vector<std::string> own_joints(const MapReader& reader) {
  std::vector<std::string> names;
  const ConfigNode* joints = reader.node("joints");
  if (joints == nullptr) return names;
  for (const ConfigEntry& entry : joints->entries) {
    const std::vector<std::string> keys = entry.value.keys();
    const std::string shared = row_at(kJointConstants, kJointDamping).key;
    const bool is_own = std::any_of(keys.begin(), keys.end(),
                                    [&](const std::string& key) { return key != shared; });
    if (is_own) names.push_back(entry.key);
  }
  return names;
}

/// The rotors file of a robot without the key `rotors`.
std::string rotors_beside(const RobotModel& model) {
  return (std::filesystem::path(model.urdf_file).parent_path() / "rotors.yaml").string();
}

/// Largest distance of a hub from its link's axis of rotation [m]: larger than round-off.
constexpr double kOnAxis = 1e-3;
/// Cosine of the angle above which that axis and the rotor's axis count as equal.
constexpr double kAlongAxis = 0.9999;

/// Hinge limits farther apart than this do not count as limits [rad]: cables and springs on a joint
/// allow a few turns, while files write 1e3 to 1e16 for a rotor.
constexpr double kFreeTravel = 20.0 * kTwoPi;

bool turns_freely(const Joint& joint) {
  const JointLimit& limit = joint.limit;
  const bool is_free = !limit.enabled || limit.upper - limit.lower > kFreeTravel;
  return joint.type == JointType::kPin && is_free;
}

/// Joints that turn freely about the axis of a rotor on them.
std::set<std::string> spinning_joints(const RobotModel& model) {
  std::set<std::string> names;
  for (const Rotor& rotor : model.rotors) {
    const Joint& joint = model.bodies[static_cast<std::size_t>(rotor.body)].joint;
    if (!turns_freely(joint)) continue;
    const Vec3<double> axis = rotate(joint.frame_in_body.rotation, Vec3<double>{0.0, 0.0, 1.0});
    const Vec3<double> arm = rotor.position() - joint.frame_in_body.position;
    const bool is_along = std::fabs(dot(axis, rotor.axis)) > kAlongAxis;
    if (is_along && norm(cross(arm, axis)) < kOnAxis) names.insert(joint.name);
  }
  return names;
}

}  // namespace

Pose read_pose(const MapReader& reader) {
  const Vec3<double> rpy = reader.vec3("rpy");
  return {reader.vec3("position"), from_rpy(rpy.x, rpy.y, rpy.z)};
}

void RobotReader::note(const std::string& text) {
  files_hash_ = combine(files_hash_, hash_string(text));
}

std::optional<RobotUse> RobotReader::read(const ConfigNode& node) {
  const MapReader reader(&node, robot_fields(), node.mark, diagnostics_);
  RobotUse robot;
  robot.name = reader.text("name");
  robot.mark = reader.mark();
  robot.pose = read_pose(MapReader(reader.node("pose"), pose_fields(), node.mark, diagnostics_));
  const MapReader load(reader.node("disturbance"), disturbance_fields(), node.mark, diagnostics_);
  read_constants(load, kRobotConstants, robot.constants.data());
  robot.controllers =
      read_plugin_uses(reader.node("controllers"), SKYBODY_CONTROLLER, catalog_, diagnostics_);
  const RobotModel* model = read_model(reader);
  if (model == nullptr || !take_parts(*model, reader.mark("model"))) {
    reader.real_or_word("rotor_speed");
    return std::nullopt;
  }
  robot.model = *model;
  read_joints(reader, robot.model);
  read_rotor_speed(reader, robot);
  return robot;
}

/// Counts a model's parts: each robot has its own copy, and the total is limited.
bool RobotReader::take_parts(const RobotModel& model, const SourceLocation& mark) {
  const bool fitted = bodies_ <= kMostBodies && parts_ <= kMostParts;
  bodies_ += model.bodies.size();
  parts_ += model.links.size() + model.rotors.size();
  for (const Body& body : model.bodies) parts_ += body.collisions.size() + body.visuals.size();
  if (bodies_ <= kMostBodies && parts_ <= kMostParts) return true;
  if (!fitted) return false;  // reported before
  diagnostics_.error(mark, "the robots up to this one have " + std::to_string(bodies_) +
                               " bodies and " + std::to_string(parts_) +
                               " links, shapes and rotors; allowed: at most " +
                               std::to_string(kMostBodies) + " and " + std::to_string(kMostParts));
  return false;
}

const RobotModel* RobotReader::read_model(const MapReader& reader) {
  const std::string written = reader.text("model");
  const bool fixed_base = reader.boolean("fixed_base");
  const std::string rotors = reader.text("rotors");
  if (written.empty()) {
    if (reader.node("model") != nullptr && reader.node("model")->is_scalar()) {
      diagnostics_.error(reader.mark("model"), "`model` is empty; allowed: a URDF file");
    }
    return nullptr;
  }
  const SourceLocation mark = reader.mark("model");
  std::string file = resolve_path(written, mark);
  if (!is_file(file)) {
    if (const auto shipped = find_shipped_model(written)) file = shipped->string();
  }
  const std::string rotors_key =
      reader.node("rotors") == nullptr ? "" : resolve_path(rotors, reader.mark("rotors"));
  const std::string key = file + '\n' + rotors_key + (fixed_base ? "\nfixed" : "\nfree") + '\n' +
                          reader.text("inertia") + '\n' + join(own_joints(reader));
  if (const auto known = models_.find(key); known != models_.end()) {
    return known->second ? &*known->second : nullptr;
  }
  std::optional<RobotModel>& model = models_[key];
  const std::string problem = missing_file(file, kModelRemedy, shipped_models());
  if (!problem.empty()) {
    diagnostics_.error(mark, problem);
    return nullptr;
  }
  const std::optional<std::string> text = read_file(file, mark, diagnostics_);
  if (!text) return nullptr;
  if (!budget_.take_file(text->size())) {
    diagnostics_.error(mark, too_much_text());
    return nullptr;
  }
  note(*text);
  model = make_model(*text, file, reader);
  if (model) note_meshes(*model);
  const bool refuses = model && model->fixed_base && !fixed_base;
  if (refuses && reader.node("fixed_base") != nullptr) {
    diagnostics_.error(reader.mark("fixed_base"), "`fixed_base` is false, but the root link of " +
                                                      file + " is `world`: remove one of them");
  }
  return model ? &*model : nullptr;
}

/// Reads the URDF and the rotors. Joints that turn freely with a rotor are known only afterwards:
/// if there are some, reads both again with these joints fixed.
std::optional<RobotModel> RobotReader::make_model(const std::string& text, const std::string& file,
                                                  const MapReader& reader) {
  const std::vector<std::string> own = own_joints(reader);
  UrdfOptions options{reader.boolean("fixed_base"), reader.text("inertia") == "repair", {}, {}};
  options.own_joints.insert(own.begin(), own.end());
  std::optional<RobotModel> model;
  for (int pass = 0; pass < 2; ++pass) {
    Diagnostics found(kMostToFold);
    model = parse_urdf(text, file, options, found);
    if (model && !add_rotors(reader, *model, found)) model.reset();
    if (model && pass == 0) options.fixed_joints = spinning_joints(*model);
    if (pass == 1 || options.fixed_joints.empty()) {
      diagnostics_.add(fold_warnings(found));
      break;
    }
  }
  return model;
}

/// Adds the meshes' bounding boxes to the hash: like the files' text, they affect the simulation.
void RobotReader::note_meshes(const RobotModel& model) {
  for (const Body& body : model.bodies) {
    for (const Shape& shape : body.collisions) {
      if (shape.type != ShapeType::kMesh) continue;
      const Vec3<double>&size = shape.box_size, &center = shape.box_center;
      note(format_numbers({size.x, size.y, size.z, center.x, center.y, center.z}));
    }
  }
}

bool RobotReader::add_rotors(const MapReader& reader, RobotModel& model, Diagnostics& diagnostics) {
  const std::string written = reader.text("rotors");
  if (written == "none") return true;
  std::string file;
  SourceLocation used_at;
  if (!written.empty()) {
    used_at = reader.mark("rotors");
    file = resolve_path(written, used_at);
  } else {
    file = rotors_beside(model);
    if (!is_file(file)) return true;
  }
  std::string text;
  const bool good = read_rotors(file, used_at, model, text, diagnostics, budget_);
  note(text);
  return good;
}

void RobotReader::read_rotor_speed(const MapReader& reader, RobotUse& robot) {
  const std::optional<double> speed = reader.real_or_word("rotor_speed");
  robot.rotor_speed = speed.value_or(-1.0);
  const SourceLocation mark = reader.mark("rotor_speed");
  const std::vector<Rotor>& rotors = robot.model.rotors;
  if (reader.node("rotor_speed") != nullptr && rotors.empty() && robot.rotor_speed != 0.0) {
    const bool is_none = reader.node("rotors") != nullptr;
    diagnostics_.error(mark, "`rotor_speed` is given, but `" + robot.name + "` has no rotors; " +
                                 (is_none ? "remove `rotors: none` or this key"
                                          : "add the file " + rotors_beside(robot.model) +
                                                ", or remove this key"));
  }
  for (const Rotor& rotor : rotors) {
    if (robot.rotor_speed <= rotor.constants[kMaxSpeed]) continue;
    diagnostics_.error(mark, "`rotor_speed` is " + format_number(robot.rotor_speed) +
                                 " rad/s; the rotor `" + rotor.name + "` turns at most at " +
                                 format_number(rotor.constants[kMaxSpeed]) + " rad/s");
    break;
  }
}

void RobotReader::read_joints(const MapReader& reader, RobotModel& model) {
  const ConfigNode* joints = reader.node("joints");
  if (joints == nullptr || joints->is_null()) return;
  if (!joints->is_map()) {
    diagnostics_.error(joints->mark,
                       "`joints` is " + joints->describe() +
                           "; allowed: a map from joint names to springs and dampers");
    return;
  }
  std::unordered_map<std::string, std::size_t> moving;
  std::vector<std::string> names;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Joint& joint = model.bodies[b].joint;
    if (!is_moving_joint(joint)) continue;
    names.push_back(joint.name);
    moving[joint.name] = b;
  }
  ModelMarks marks = *model.marks;
  for (const ConfigEntry& entry : joints->entries) {
    const auto found = moving.find(entry.key);
    if (found != moving.end()) {
      read_joint(entry, model.bodies[found->second].joint, marks.bodies[found->second]);
      continue;
    }
    diagnostics_.error(entry.key_mark, "`" + entry.key + "` is not a moving joint of " +
                                           model.urdf_file +
                                           suggestion(entry.key, names, "joints"));
  }
  model.marks = std::make_shared<const ModelMarks>(std::move(marks));
}

void RobotReader::read_joint(const ConfigEntry& entry, Joint& joint, BodyMarks& marks) {
  const MapReader reader(&entry.value, joint_fields(), entry.key_mark, diagnostics_);
  const bool springs = joint.type == JointType::kPin || joint.type == JointType::kSlider;
  for (const ConstantRow& row : kJointConstants) {
    const double read = reader.real(row.key);
    if (reader.node(row.key) == nullptr) continue;
    joint.constants[static_cast<std::size_t>(row.place)] = read;
    marks.joint[static_cast<std::size_t>(row.place)] = reader.mark(row.key);
    if (row.place < joint_constant_count(joint)) continue;
    diagnostics_.error(reader.mark(row.key),
                       "`" + std::string(row.key) + "` does not apply to the joint `" + entry.key +
                           "`, which " +
                           (springs ? "has no limits" : "is not revolute or prismatic"));
  }
  read_joint_position(reader, entry.key, joint);
}

void RobotReader::read_joint_position(const MapReader& reader, const std::string& name,
                                      Joint& joint) {
  if (reader.node("position") == nullptr) return;
  joint.position = reader.real("position");
  const auto refuse = [&](const std::string& why) {
    diagnostics_.error(reader.mark("position"), "`position` of the joint `" + name + "` " + why);
  };
  if (joint.type != JointType::kPin && joint.type != JointType::kSlider) {
    refuse("is given, which is not revolute or prismatic");
  } else if (joint.limit.enabled &&
             (joint.position < joint.limit.lower || joint.position > joint.limit.upper)) {
    refuse("is " + format_number(joint.position) + "; its limits are " +
           format_number(joint.limit.lower) + " to " + format_number(joint.limit.upper));
  }
}

}  // namespace skybody
