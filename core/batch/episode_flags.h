// Flags of the episodes of a pool's environments: wanted, begun, ended.
#pragma once

#include <cstdint>

#include "core/batch/batch.h"
#include "core/batch/environment_groups.h"
#include "core/batch/lane_flags.h"
#include "core/env/state_group.h"

namespace skybody {

/// The caller sets the kind of the next transition; the thread that runs a group sets the others.
class EpisodeFlags {
 public:
  explicit EpisodeFlags(EnvironmentGroups places)
      : places_(places),
        wants_reset_(places.count()),
        started_(places.count()),
        ended_(places.count()) {}

  /// The kind of the next transition of an environment: a step or a reset.
  void want_reset(int env) { wants_reset_.set(places_.group_of(env), places_.bit(env), true); }
  void want_step(int env) { wants_reset_.set(places_.group_of(env), places_.bit(env), false); }
  void want_step_all() { wants_reset_.clear(); }
  /// Whether all environments can be stepped without a reset.
  /// @param renews  ended episodes are followed by a reset
  bool can_step_all(bool renews) const;

  bool started(int env) const { return is_set(started_, env); }
  bool ended(int env) const { return is_set(ended_, env); }
  /// Lanes of a group.
  std::uint32_t wanting_reset(int group) const { return wants_reset_.of(group); }
  std::uint32_t ended_lanes(int group) const { return ended_.of(group); }

  /// No episode has begun.
  void clear();
  /// Sets the flags of an environment from its state words, after a restore.
  void refresh(int env, const StateGroup& group);
  void set_ended(int env, bool has_ended) {
    ended_.set(places_.group_of(env), places_.bit(env), has_ended);
  }
  /// Sets the flags, and those of the rows, from the status of a transition.
  /// @param steps  of the episode, one per lane
  void describe(int group, std::uint32_t mask, const std::uint64_t* steps, bool is_reset,
                Batch& rows);

 private:
  bool is_set(const AtomicLaneMasks& flags, int env) const {
    return (flags.of(places_.group_of(env)) & places_.bit(env)) != 0;
  }

  EnvironmentGroups places_;
  AtomicLaneMasks wants_reset_;      ///< written by the caller
  AtomicLaneMasks started_, ended_;  ///< written by the thread that runs the group
};

}  // namespace skybody
