// Reads one entry of `robots`: its model from files, its pose, joints and controllers.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/diagnostics.h"
#include "core/io/yaml/field.h"
#include "core/io/yaml/plugin_catalog.h"
#include "core/model/model_marks.h"
#include "core/model/scenario.h"

namespace skybody {

/// Reads robots. A model shared by several robots is read once.
class RobotReader {
 public:
  RobotReader(const PluginCatalog& catalog, InputBudget& budget, Diagnostics& diagnostics)
      : catalog_(catalog), budget_(budget), diagnostics_(diagnostics) {}

  /// The robot, or nullopt if its model cannot be read (other errors leave defaults).
  std::optional<RobotUse> read(const ConfigNode& node);

  /// Hash over the contents of all model files read so far, in order.
  std::uint64_t files_hash() const { return files_hash_; }

 private:
  /// The model, or null after errors; owned by the reader.
  const RobotModel* read_model(const MapReader& reader);
  std::optional<RobotModel> make_model(const std::string& text, const std::string& file,
                                       const MapReader& reader);
  void note_meshes(const RobotModel& model);
  bool add_rotors(const MapReader& reader, RobotModel& model, Diagnostics& diagnostics);
  void read_joints(const MapReader& reader, RobotModel& model);
  void read_joint(const ConfigEntry& entry, Joint& joint, BodyMarks& marks);
  void read_joint_position(const MapReader& reader, const std::string& name, Joint& joint);
  void read_rotor_speed(const MapReader& reader, RobotUse& robot);
  void note(const std::string& text);
  bool take_parts(const RobotModel& model, const SourceLocation& mark);

  const PluginCatalog& catalog_;
  InputBudget& budget_;
  Diagnostics& diagnostics_;
  std::size_t bodies_ = 0;  ///< of all robots so far
  std::size_t parts_ = 0;   ///< links, shapes, rotors of all robots
  std::map<std::string, std::optional<RobotModel>> models_;  ///< by files and options
  std::uint64_t files_hash_ = 0;
};

/// The pose from the keys for position and rpy, computed with core/base.
Pose read_pose(const MapReader& reader);

}  // namespace skybody
