// Division of a pool's environments into lane groups.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/base/simd/lane_mask.h"

namespace skybody {

/// Environments of one group are stored side by side: `span` of them, fewer in the last group. The
/// span is 1 where the physics runs lane by lane, or where larger groups would leave threads idle.
struct EnvironmentGroups {
  int envs, span;

  int count() const { return (envs + span - 1) / span; }
  int group_of(int env) const { return env / span; }
  int lane_of(int env) const { return env % span; }
  int env_of(int group, int lane) const { return group * span + lane; }
  std::uint32_t bit(int env) const { return 1u << lane_of(env); }
  /// The lanes of a group that have an environment.
  std::uint32_t all_lanes(int group) const {
    return first_lanes(std::min(span, envs - group * span));
  }
};

}  // namespace skybody
