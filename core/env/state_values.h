// The values of an environment's state that can be read by path: motion, rotors, sensors, contacts,
// counters and EnvParams. This list is the only one: Pool, SimulationPool, Simulation, Python and
// `skybody check --states` read through it.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/env/state_group.h"

namespace skybody {

class CompiledScenario;

/// The source of a state value.
enum class StateSource {
  kReals,   ///< consecutive state words, as doubles
  kHeader,  ///< a counter or status of the header, as a double
  kTime,    ///< physics steps of the episode times dt
  kBodies,  ///< a part of the BodyState of one body, or of several consecutive bodies
  kLink,    ///< a part of the motion of a link, which lies in its body at `pose`
};

/// One value, or array of values, that every environment of a scenario has.
struct StateValue {
  std::string path;        ///< such as robots.quad.base.position
  std::string unit;        ///< SI; empty for a pure number
  std::string alias = {};  ///< the same by a rotor's name or a joint's index; may be empty
  const char* frame = "";  ///< W: world axes, B: axes of the body or link; empty: no frame
  std::vector<int> shape;  ///< for one environment; empty: a single number
  const char* doc = "";    ///< one line

  StateSource source = StateSource::kReals;
  int first = 0;  ///< kReals, kHeader: state word; kBodies, kLink: world body index
  int part = 0;   ///< kBodies, kLink: first of the 13 values of a BodyState
  Pose pose;      ///< kLink: pose of the link in its body

  /// Number of doubles for one environment.
  int count() const {
    int product = 1;
    for (const int extent : shape) product *= extent;
    return product;
  }
  /// Whether it depends on the bodies, which must then be current in the group.
  bool needs_bodies() const {
    return source == StateSource::kBodies || source == StateSource::kLink;
  }
};

/// All values of one environment, found by path. Immutable.
///
/// A sensor's channel hides an EnvParam of the same path, which can then be read by param() only.
class StateValues {
 public:
  explicit StateValues(const CompiledScenario& compiled);

  /// World first, then robots, sensors and EnvParams.
  const std::vector<StateValue>& all() const { return values_; }
  /// Does not allocate if the value exists.
  /// @throws Error with the nearest paths if there is no such value
  const StateValue& at(std::string_view path) const;

  /// Reads a value of one lane. If needs_bodies(), the lane must be up to date
  /// (CompiledScenario::update).
  /// @param out  room for value.count() doubles
  void read(const StateValue& value, const StateGroup& group, int lane, double* out) const;

 private:
  bool has_prefix(const std::string& prefix) const;
  std::vector<std::string> words_after(const std::string& prefix) const;
  [[noreturn]] void refuse(std::string_view path) const;

  double dt_ = 0.0;
  std::vector<StateValue> values_;
  std::map<std::string, int, std::less<>> by_path_;  ///< indices of values_, aliases included
};

}  // namespace skybody
