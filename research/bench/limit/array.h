// An array of environments for a limit loop, on one thread or two.
#pragma once

#include <algorithm>

#include "core/base/simd/aligned_array.h"
#include "research/bench/limit/loop.h"

namespace skybody::bench::limit {

/// N environments; all begin an episode in the first round.
class EnvironmentArray {
 public:
  /// @param envs  a multiple of the loop's width   @param repeats  physics steps per step, K
  EnvironmentArray(const LoopKind& kind, int envs, int repeats)
      : kind_(kind),
        envs_(envs),
        repeats_(repeats),
        blocks_(static_cast<std::size_t>(envs / kind.width) * kind.block_bytes),
        observation_(static_cast<std::size_t>(envs) * static_cast<std::size_t>(kind.observation)),
        reward_(static_cast<std::size_t>(envs)),
        ended_(static_cast<std::size_t>(envs)) {
    std::fill_n(ended_.data(), ended_.size(), std::uint8_t{1});
  }

  /// Steps a share of the environments: share 0 or 1 of 2, or 0 of 1.
  void step(const float* actions, int share = 0, int shares = 1) {
    const int blocks = envs_ / kind_.width;
    kind_.run({blocks_.data(),
               {actions, observation_.data(), reward_.data(), ended_.data()},
               blocks * share / shares,
               blocks * (share + 1) / shares,
               repeats_});
  }

  int envs() const { return envs_; }
  const float* observation(int env) const {
    return observation_.data() + static_cast<std::ptrdiff_t>(env) * kind_.observation;
  }
  float reward(int env) const { return reward_[static_cast<std::size_t>(env)]; }
  std::uint8_t& ended(int env) { return ended_[static_cast<std::size_t>(env)]; }

  /// State value k of an environment.
  double& value(int env, int k) {
    auto* block = reinterpret_cast<double*>(
        blocks_.data() + static_cast<std::size_t>(env / kind_.width) * kind_.block_bytes);
    return block[k * kind_.width + env % kind_.width];
  }

 private:
  LoopKind kind_;
  int envs_, repeats_;
  AlignedArray<std::byte> blocks_;
  AlignedArray<float> observation_, reward_;
  AlignedArray<std::uint8_t> ended_;
};

}  // namespace skybody::bench::limit
