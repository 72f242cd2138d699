// State words at the beginning of an episode, before and after draws.
#pragma once

#include <cstdint>

#include "core/env/effects_phase.h"
#include "core/env/scenario_model.h"

namespace skybody {

/// Immutable; refers to the model, which must outlive it.
class EpisodeStart {
 public:
  explicit EpisodeStart(const ScenarioModel& model) : model_(model), effects_(model) {}

  /// Initializes one lane: nominal parameters, episode 0, the given random key.
  void initialize(StateGroup& group, int lane, std::uint64_t seed, std::uint64_t stream_env) const;
  /// The scenario's poses, velocities, rotors, held commands and joint drives.
  void place(StateGroup& group, int lane) const;
  /// Sets counters, places robots by their EnvParams, and clears commands and the words of plugins,
  /// except those of randomizers. Drawn parameters persist until a randomizer is due.
  void begin(StateGroup& group, std::uint32_t mask) const;
  /// Position drives begin at the joints' positions, drawn or not.
  void settle_joint_drives(StateGroup& group, std::uint32_t mask) const;
  /// Stops the rotors of robots that a wrench or a drive moves instead: otherwise rotors that run
  /// down would push them as well.
  void silence_rotors(StateGroup& group, std::uint32_t mask) const;
  /// Calls reset() of all plugins of a kind.
  void reset_plugins(SkybodyKind kind, StateGroup& group, GroupWorkspace& work,
                     std::uint32_t mask) const;

 private:
  void clear_plugin_states(StateGroup& group, std::uint32_t mask) const;

  const ScenarioModel& model_;
  EffectsPhase effects_;
};

}  // namespace skybody
