// The values of a lane group in some transitions, before each physics step and after the last one.
#pragma once

#include <cstdint>

#include "core/derivative/dual_group.h"
#include "core/env/compiled_scenario.h"
#include "core/env/state_group.h"

namespace skybody {

/// The recorded part of a group.
enum class RecordPart {
  kAll,
  kMotion,   ///< coordinates, rotor speeds and bodies
  kCommands  ///< the present outputs of controllers and effects
};

class TransitionRecords {
 public:
  /// @param steps  greatest number of transitions
  TransitionRecords(const CompiledScenario& compiled, const DualGroup& dual, int steps);

  /// Physics steps of a transition.
  int repeat() const { return repeat_; }

  /// @param t  transition
  /// @param k  physics step, repeat() after the last one
  void remember(const StateGroup& group, int t, int k, RecordPart part);
  /// Loads a record into the values of a dual group; tangents remain.
  void show(int t, int k, DualGroup& dual) const;
  /// The same for the words of plugins only: restores the words that a call has changed.
  void show_plugin_state(int t, int k, DualGroup& dual) const;

  /// A recorded row of a dual group.
  const double* row(int t, int k, int row) const;
  const std::uint64_t* words(int t, int k, int row) const {
    return reinterpret_cast<const std::uint64_t*>(this->row(t, k, row));
  }

 private:
  std::ptrdiff_t place(int t, int k) const {
    return (static_cast<std::ptrdiff_t>(t) * (repeat_ + 1) + k) * record_size_;
  }

  const StateLayout& layout_;
  int repeat_;
  int early_rows_;  ///< words from the header on, up to the parameters
  int late_first_;  ///< words from the action on, up to the last observation
  int late_rows_;
  int body_first_, body_rows_;  ///< rows of the dual group
  std::ptrdiff_t record_size_;
  AlignedArray<double> records_;
};

}  // namespace skybody
