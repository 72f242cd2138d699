// A caller's changes of randomizable values: applied now, or when the next episode begins.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/math/distribution.h"
#include "core/base/math/random.h"
#include "core/model/state_layout.h"

namespace skybody {

class CompiledScenario;

/// Meaning of a drawn number.
enum class ChangeForm {
  kValue,  ///< the new value
  kScale,  ///< a factor on the nominal value
  kShift   ///< added to the nominal value
};

/// When a request is applied.
enum class RequestTime {
  kNextStep,  ///< with the next transition that is sent
  kNextReset  ///< when the next episode begins
};

/// One change: values by path, and their distribution.
struct ParamChange {
  std::string path;  ///< of one or several values, in the notation of randomizers
                     ///< (docs/scenarios.md)
  Distribution distribution;
  ChangeForm form = ChangeForm::kValue;
  bool is_shared = false;  ///< one draw for all values, not one for each

  /// The change as one line for read_param_change(): `path form distribution numbers`.
  std::string text() const;
};

/// @throws Error if the text is not such a line
ParamChange read_param_change(const std::string& text);
std::vector<ParamChange> read_param_changes(const std::vector<std::string>& lines);

/// Changes, resolved and checked for one compiled scenario. Immutable.
class ParamRequest {
 public:
  /// @param redraws  all randomizers draw as well, before the changes
  /// @throws Error (with the path) if the path names nothing, two changes name the same value, or a
  ///   value may leave its bounds
  ParamRequest(const CompiledScenario& compiled, std::span<const ParamChange> changes,
               bool redraws);

  bool redraws() const { return redraws_; }
  /// Changed places of initial states (core/env/initial_states.h).
  const std::vector<int>& starts() const { return starts_; }
  /// The changes from which the request was made.
  const std::vector<ParamChange>& changes() const { return changes_; }

  /// Calls f(parameter index, value) for every changed value.
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
    int param;           ///< index within the parameter block
    std::size_t change;  ///< index within `changes_`
    double factor, offset;
    bool draws;  ///< false: uses the number of the previous value
  };
  void add(const EnvParam& info, int param, std::size_t change, bool is_first);

  std::vector<ParamChange> changes_;
  std::vector<Target> targets_;
  std::vector<int> starts_;
  bool redraws_;
};

}  // namespace skybody
