// Callers' requests of parameters on their way to the environments.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/env/compiled_scenario.h"
#include "core/env/group_workspace.h"
#include "core/env/param_request.h"

namespace skybody {

/// The caller asks while environments are in flight. It hands the requests of an environment over
/// before it sends it; then only the thread that runs the environment's group uses them.
class RequestQueues {
 public:
  explicit RequestQueues(int envs);

  // --- the caller
  // ---------------------------------------------------------------------------------

  /// Adds a request for the transitions of an environment that are sent from now on.
  /// @param at_reset  true: at the next begin of an episode; false: before the next transition, or,
  ///   if that is a reset, in it
  void ask(int env, std::shared_ptr<const ParamRequest> request, bool at_reset);
  /// Hands an environment's requests over to the thread that runs it next. Call it before sending.
  void hand_over(int env) {
    if (has_asked_) hand_over_asked(env);
  }
  void hand_over_all();
  /// Drops all requests. No environment may be in flight.
  void clear();

  // --- the thread that runs a group
  // ---------------------------------------------------------------

  /// Whether any request was handed over so far.
  bool has_handed() const { return has_handed_.load(std::memory_order_relaxed); }
  /// Applies requests before a step; requests for a reset wait.
  /// @param first  environment of lane 0
  void apply(const CompiledScenario& compiled, int first, std::uint32_t mask, StateGroup& group,
             GroupWorkspace& work);
  /// Passes requests to a reset.
  /// @param takes_all  also requests for the next transition, because the reset is that transition
  void begin_reset(int first, std::uint32_t mask, bool takes_all, GroupWorkspace& work);
  /// Called after that reset.
  void end_reset(int first, std::uint32_t mask, GroupWorkspace& work);

 private:
  struct Asked {
    std::shared_ptr<const ParamRequest> request;
    bool at_reset;
  };
  using Requests = std::vector<std::shared_ptr<const ParamRequest>>;
  void hand_over_asked(int env);

  std::vector<std::vector<Asked>> asked_;   ///< per environment, not yet handed over
  std::vector<std::vector<Asked>> handed_;  ///< for the next transition
  std::vector<Requests> waiting_;           ///< for the next reset
  bool has_asked_ = false;                  ///< any request so far
  std::atomic<bool> has_handed_{false};
};

}  // namespace skybody
