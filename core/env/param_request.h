// What a caller asks to become of randomizable values: now, or when the next episode begins.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/distribution.h"
#include "core/base/random.h"
#include "core/model/layout.h"

namespace skybody {

class CompiledScenario;

/// What a drawn number is to a value.
enum class ChangeForm {
  kValue,  ///< the value itself
  kScale,  ///< a factor on the nominal value
  kShift   ///< is added to the nominal value
};

/// When what is asked for is done.
enum class RequestTime {
  kNextStep,  ///< with the next transition that is sent
  kNextReset  ///< when the next episode begins
};

/// One setpoint: values by path, and what they are drawn from.
struct ParamChange {
  std::string path;  ///< of one or several, as randomizers name them (docs/scenarios.md)
  Distribution distribution;
  ChangeForm form = ChangeForm::kValue;
  bool is_shared = false;  ///< one draw for all of them, not one for each

  /// One line that read_param_change() takes: `path form distribution numbers`.
  std::string text() const;
};

/// @throws Error if it is no such line
ParamChange read_param_change(const std::string& text);
std::vector<ParamChange> read_param_changes(const std::vector<std::string>& lines);

/// Wishes, resolved and checked for one compiled scenario. Immutable.
class ParamRequest {
 public:
  /// @param redraws  all randomizers draw as well, before the changes
  /// @throws Error (naming the path) if nothing is called so, two changes name one value, or a
  ///         value may come out beyond its bounds
  ParamRequest(const CompiledScenario& compiled, std::span<const ParamChange> changes,
               bool redraws);

  bool redraws() const { return redraws_; }
  /// Places of starts (core/env/initial_states.h) that it changes.
  const std::vector<int>& starts() const { return starts_; }
  /// What it was made of.
  const std::vector<ParamChange>& changes() const { return changes_; }

  /// Calls f(parameter index, value) for every value that it names.
  /// @param random  the request's own numbers
  template <class F>
  void each_value(Random<double> random, const F& f) const {
    double u = 0.0;
    for (const Target& t : targets_) {
      if (t.draws) u = random.uniform();
      f(t.param, changes_[t.change].distribution.at(u) * t.factor + t.offset);
    }
  }

 private:
  struct Target {
    int param;           ///< in the parameter block
    std::size_t change;  ///< of `changes_`
    double factor, offset;
    bool draws;  ///< else it has the number of the one before
  };
  void add(const EnvParam& info, int param, std::size_t change, bool is_first);

  std::vector<ParamChange> changes_;
  std::vector<Target> targets_;
  std::vector<int> starts_;
  bool redraws_;
};

}  // namespace skybody
