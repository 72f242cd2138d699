// Topology and parameters of a world in the C form that plugins see in configure().
#pragma once

#include <string>
#include <vector>

#include "core/env/controller_chains.h"
#include "core/env/plugin_instance.h"
#include "core/physics/world/world.h"
#include "plugins/api/abi.h"

namespace skybody {

/// Values of parameters in C form. Points into them.
class BoundValues {
 public:
  explicit BoundValues(const std::vector<ParameterValue>& values);
  const std::vector<SkybodyValue>& table() const { return table_; }
  /// Says that a value is the EnvParams from `param` on.
  void set_env_param(std::size_t index, int param) { table_[index].env_param = param; }

 private:
  std::vector<std::vector<const char*>> texts_;
  std::vector<SkybodyValue> table_;
};

/// Tables behind SkybodySetup. They point into topology and layout and stay valid as long as
/// those do.
class SetupTables {
 public:
  /// @param layout  with all EnvParams
  SetupTables(const Topology& topology, const Layout& layout);

  /// The setup for one plugin use. `values` are its parameters with their EnvParam indices.
  /// @param team  robots that a controller serves; as long as the setup
  SkybodySetup setup(const std::string& instance, const std::vector<int>& team,
                     const std::vector<SkybodyValue>& values) const;

  /// Collision shapes of bodies, then obstacles.
  const std::vector<SkybodyShapeInfo>& shapes() const { return shapes_; }

  /// Makes a configured sensor's channels visible to those configured later.
  void add_sensor(const PluginInstance& sensor);
  /// Tells the chains that the action commands, once the controllers are configured.
  void set_chains(const std::vector<ControllerChain>& chains);

 private:
  const Scenario& scenario_;
  const Layout& layout_;
  std::vector<SkybodyRobotInfo> robots_;
  std::vector<SkybodyBodyInfo> bodies_;
  std::vector<SkybodyLinkInfo> links_;
  std::vector<SkybodyRotorInfo> rotors_;
  std::vector<SkybodySensorInfo> sensors_;
  std::vector<SkybodyChainInfo> chains_;
  std::vector<SkybodyShapeInfo> shapes_;
  std::vector<SkybodyEnvParamInfo> params_;
  std::vector<std::unique_ptr<std::string>> names_;  ///< texts of sensors_
};

/// A SkybodyDeclare that writes into `instance`.
SkybodyDeclare declare_into(PluginInstance& instance);

}  // namespace skybody
