#include "core/batch/request_queues.h"

#include <utility>

#include "core/base/simd/lane_mask.h"

namespace skybody {
namespace {

std::size_t queue_of(int env) { return static_cast<std::size_t>(env); }

}  // namespace

RequestQueues::RequestQueues(int envs)
    : asked_(queue_of(envs)), handed_(queue_of(envs)), waiting_(queue_of(envs)) {}

void RequestQueues::ask(int env, std::shared_ptr<const ParamRequest> request, bool at_reset) {
  has_asked_ = true;
  asked_[queue_of(env)].push_back({std::move(request), at_reset});
}

/// The environment is not in flight: no thread runs it.
void RequestQueues::hand_over_asked(int env) {
  std::vector<Asked>& asked = asked_[queue_of(env)];
  if (asked.empty()) return;
  handed_[queue_of(env)].swap(asked);
  has_handed_.store(true, std::memory_order_relaxed);
}

void RequestQueues::hand_over_all() {
  if (!has_asked_) return;
  for (int env = 0; env < static_cast<int>(asked_.size()); ++env) hand_over_asked(env);
}

void RequestQueues::clear() {
  if (!has_asked_) return;
  for (std::size_t env = 0; env < asked_.size(); ++env) {
    asked_[env].clear();
    handed_[env].clear();
    waiting_[env].clear();
  }
}

void RequestQueues::apply(const CompiledScenario& compiled, int first, std::uint32_t mask,
                          StateGroup& group, GroupWorkspace& work) {
  each_lane(mask, [&](int lane) {
    const std::size_t env = queue_of(first + lane);
    for (Asked& asked : handed_[env]) {
      if (asked.at_reset) {
        waiting_[env].push_back(std::move(asked.request));
      } else {
        compiled.apply(group, work, lane, *asked.request);
      }
    }
    handed_[env].clear();
  });
}

void RequestQueues::begin_reset(int first, std::uint32_t mask, bool takes_all,
                                GroupWorkspace& work) {
  each_lane(mask, [&](int lane) {
    const std::size_t env = queue_of(first + lane);
    for (Asked& asked : handed_[env]) {
      if (takes_all) waiting_[env].push_back(std::move(asked.request));
    }
    if (takes_all) handed_[env].clear();
    work.requests[queue_of(lane)] = waiting_[env];
  });
}

void RequestQueues::end_reset(int first, std::uint32_t mask, GroupWorkspace& work) {
  work.clear_requests();
  each_lane(mask, [&](int lane) { waiting_[queue_of(first + lane)].clear(); });
}

}  // namespace skybody
