// The phases of a transition on dual numbers: the plugins' own code, and the engine's physics.
#pragma once

#include <cstdint>

#include "core/derivative/dual_group.h"
#include "core/derivative/transition_records.h"
#include "core/env/compiled_scenario.h"
#include "core/physics/step/dual_kernels.h"

namespace skybody {

/// A recorded physics step of a group, and the lanes to evaluate.
struct RecordedStep {
  const TransitionRecords& records;
  int t, k;
  std::uint32_t lanes;

  const std::uint64_t* words(int row) const { return records.words(t, k, row); }
};

/// Each call works on the values of a dual group, loaded from a record (TransitionRecords::show).
/// It writes values and tangents of its outputs and leaves the values of its inputs unchanged.
class DualTransition {
 public:
  /// @param compiled, plan, dual  must outlive it
  DualTransition(const CompiledScenario& compiled, const StepPlan& plan, DualGroup& dual);

  /// Sets the group's parameters and the values derived from them, in lanes; they must outlive the
  /// calls.
  void set_parameters(const double* params, double* derived) {
    blocks_.params = params;
    derived_ = derived;
  }

  void control(const RecordedStep& step);
  void apply_effects(const RecordedStep& step);
  void evaluate(const RecordedStep& step);
  /// The motion of bodies from q and u.
  void find_motion(const RecordedStep& step);
  /// A physics step without contact.
  void advance(const RecordedStep& step);

 private:
  SkybodyLanes view_of(const RecordedStep& step);
  void control(const ControllerChain& chain, const SkybodyLanes& view);
  std::uint32_t due(const PluginInstance& plugin, const SkybodyLanes& view) const;
  void set_neutral(int input, const Block& block, std::uint32_t lanes);
  void add_up_held(int input, std::uint32_t lanes);
  StepCall call(double* bodies);

  const CompiledScenario& compiled_;
  const StepPlan& plan_;
  const StateLayout& layout_;
  DualGroup& dual_;
  GroupBlocks blocks_;
  double* derived_ = nullptr;
  DualKernel *motion_, *step_;
  AlignedArray<double> signal_[2], no_bodies_;
  AlignedArray<std::uint64_t> end_;
  AlignedArray<double> robot_rewards_, infos_;
  AlignedArray<std::byte> scratch_;
};

}  // namespace skybody
