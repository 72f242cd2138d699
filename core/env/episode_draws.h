// Randomizer draws: at a reset, again if robots would begin inside something, during an episode,
// and on request.
#pragma once

#include <cstdint>
#include <optional>

#include "core/env/episode_start.h"
#include "core/env/scenario_model.h"
#include "core/env/start_overlaps.h"

namespace skybody {

class ParamRequest;

/// Immutable; refers to its arguments, which must outlive it.
class EpisodeDraws {
 public:
  /// @param overlaps  null: starts are not checked
  EpisodeDraws(const ScenarioModel& model, const EpisodeStart& start,
               const StartOverlaps* overlaps);

  /// Whether a randomizer draws during an episode.
  bool draws_in_time() const { return draws_in_time_; }

  /// Draws the start of an episode: randomizers, callers' requests, the task's own parameters.
  void draw_start(StateGroup& group, GroupWorkspace& work, std::uint32_t mask) const;
  /// Runs the randomizers that draw before each physics step. Lanes without a change keep their
  /// parameters and all data derived from them.
  void draw_in_time(StateGroup& group, GroupWorkspace& work, const SkybodyLanes& lanes) const;
  /// Draws from all randomizers now, regardless of their schedule. Episode and motion continue.
  void randomize(StateGroup& group, GroupWorkspace& work, std::uint32_t mask) const;
  /// Applies a caller's request in one lane. Episode and motion continue.
  void apply(StateGroup& group, GroupWorkspace& work, int lane, const ParamRequest& request) const;

 private:
  void draw(StateGroup& group, const SkybodyLanes& lanes, SkybodyOccasion occasion) const;
  void draw_with_requests(StateGroup& group, const GroupWorkspace& work, const SkybodyLanes& lanes,
                          int repetition) const;
  void draw_task(StateGroup& group, GroupWorkspace& work, std::uint32_t mask) const;
  void draw_again(StateGroup& group, GroupWorkspace& work, int lane) const;
  std::optional<StartOverlap> find_overlap(StateGroup& group, GroupWorkspace& work, int lane) const;
  void keep_undrawn(const StateGroup& group, GroupWorkspace& work) const;
  void put_back_undrawn(StateGroup& group, const GroupWorkspace& work, int lane) const;
  void hold_to_bounds(StateGroup& group, std::uint32_t mask, int param) const;

  const ScenarioModel& model_;
  const EpisodeStart& start_;
  const StartOverlaps* overlaps_;
  bool draws_in_time_ = false;
  bool draws_bodies_;  ///< whether randomizers write mass properties of bodies
};

}  // namespace skybody
