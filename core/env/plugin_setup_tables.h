// Topology and parameters of a world in the C structures that plugins receive in configure().
#pragma once

#include <string>
#include <vector>

#include "core/env/controller_chains.h"
#include "core/env/mesh_tables.h"
#include "core/env/picture_tables.h"
#include "core/env/plugin_instance.h"
#include "core/physics/world/world.h"
#include "core/plugin_abi/abi.h"

namespace skybody {

/// Values of parameters as C structures, which point into the originals.
class BoundValues {
 public:
  explicit BoundValues(const std::vector<ParameterValue>& values);
  const std::vector<SkybodyValue>& table() const { return table_; }
  /// Marks a value as the EnvParams from `param` on.
  void set_env_param(std::size_t index, int param) { table_[index].env_param = param; }

 private:
  std::vector<std::vector<const char*>> texts_;
  std::vector<SkybodyValue> table_;
};

/// Tables behind SkybodySetup. They point into topology and layout and are valid as long as these
/// live.
class SetupTables {
 public:
  /// @param layout  with all EnvParams
  SetupTables(const Topology& topology, const StateLayout& layout);

  /// The setup for one plugin use.
  /// @param team    robots that a controller serves; must outlive the setup
  /// @param values  its parameters with their EnvParam indices
  SkybodySetup setup(const std::string& instance, const std::vector<int>& team,
                     const std::vector<SkybodyValue>& values) const;

  /// Collision shapes of bodies, then obstacles.
  const std::vector<SkybodyShapeInfo>& shapes() const { return shapes_; }
  /// Shapes that are drawn, in body order.
  const std::vector<SkybodyVisualInfo>& visuals() const { return visuals_; }
  const std::vector<SkybodyRotorInfo>& rotors() const { return rotors_; }

  /// Makes a configured sensor's channels visible to those configured later.
  void add_sensor(const PluginInstance& sensor);
  /// Sets the chains that the action commands, once the controllers are configured.
  void set_chains(const std::vector<ControllerChain>& chains);

 private:
  void add_shapes(const Topology& topology);
  void add_visuals(const Topology& topology);

  const Scenario& scenario_;
  const StateLayout& layout_;
  std::vector<SkybodyRobotInfo> robots_;
  std::vector<SkybodyBodyInfo> bodies_;
  std::vector<SkybodyLinkInfo> links_;
  std::vector<SkybodyRotorInfo> rotors_;
  std::vector<SkybodySensorInfo> sensors_;
  std::vector<SkybodyChainInfo> chains_;
  std::vector<SkybodyShapeInfo> shapes_;
  std::vector<SkybodyVisualInfo> visuals_;
  std::vector<const Shape*> visual_shapes_;  ///< of visuals_
  mutable MeshTables meshes_;
  mutable PictureTables pictures_;
  std::vector<SkybodyEnvParamInfo> params_;
  std::vector<std::unique_ptr<std::string>> names_;  ///< texts referenced by sensors_
};

/// A SkybodyDeclare that writes into `instance`.
SkybodyDeclare declare_into(PluginInstance& instance);

}  // namespace skybody
