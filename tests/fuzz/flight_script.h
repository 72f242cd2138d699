// Calls of Simulation and Pool as lines of text: `step 0.1 nan 1e300`, `teleport 0 0 1 ...`.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/simulation/simulation.h"

namespace skybody::fuzz {

/// Values of one line, after its first word.
using Values = std::vector<double>;

/// Executes script lines on one environment under direct control.
class FlightScript {
 public:
  explicit FlightScript(std::shared_ptr<const CompiledScenario> compiled);

  /// @returns false if there is no such call
  /// @throws Error as the call does
  bool call(const std::string& name, const Values& values);

  const Simulation& simulation() const { return simulation_; }

  /// Names of the calls.
  static std::vector<std::string> names();

 private:
  struct Call;
  static const std::vector<Call>& calls();
  const RobotUse& robot(double index) const;
  void step(const Values& values);
  void command(const Values& values);
  void advance(const Values& values);
  void teleport(const Values& values);
  void set_param(const Values& values, bool is_factor);
  void set_mass(const Values& values);
  void set_rotor(const Values& values);
  void fork(const Values& values);
  void look();

  Simulation simulation_;
  Snapshot saved_;
  std::int64_t budget_;  ///< remaining physics steps for advance()
};

}  // namespace skybody::fuzz
