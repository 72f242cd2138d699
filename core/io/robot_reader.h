// One entry of `robots`: its model from files, its place, joints and controllers.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "core/io/config_tree.h"
#include "core/io/diagnostics.h"
#include "core/io/field.h"
#include "core/io/plugin_catalog.h"
#include "core/model/scenario.h"

namespace skybody {

/// Reads robots; models that several robots share are read once.
class RobotReader {
 public:
  RobotReader(const PluginCatalog& catalog, Diagnostics& diagnostics)
      : catalog_(catalog), diagnostics_(diagnostics) {}

  /// The robot, or nothing where its model cannot be read (other errors leave defaults).
  std::optional<RobotUse> read(const ConfigNode& node);

  /// Hash over the contents of all model files read so far, in order.
  std::uint64_t files_hash() const { return files_hash_; }

 private:
  std::optional<RobotModel> read_model(const MapReader& reader);
  bool add_rotors(const MapReader& reader, RobotModel& model);
  void read_joints(const MapReader& reader, RobotModel& model);
  void read_joint(const ConfigEntry& entry, RobotModel& model);
  void read_rotor_speed(const MapReader& reader, RobotUse& robot);
  void note(const std::string& text);

  const PluginCatalog& catalog_;
  Diagnostics& diagnostics_;
  std::map<std::string, std::optional<RobotModel>> models_;  ///< by files and options
  std::uint64_t files_hash_ = 0;
};

/// Position and rpy, by core/base math.
Pose read_pose(const MapReader& reader);

}  // namespace skybody
