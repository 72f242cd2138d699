#include "bench/limit/hover_check.h"

#include <cmath>
#include <cstring>
#include <vector>

#include "bench/limit/array.h"
#include "bench/limit/hover_block.h"
#include "core/assemble/load.h"
#include "core/env/environment.h"
#include "core/env/group_work.h"

namespace skybody::bench::limit {
namespace {

constexpr int kGroup = 8;  // environments that are compared: one of the engine's groups

/// Actions in [middle - spread, middle + spread], a fixed sequence.
class Actions {
 public:
  Actions(float middle, float spread) : middle_(middle), spread_(spread) {}
  void fill(std::vector<float>& rows) {
    for (float& a : rows) {
      seed_ = seed_ * 6364136223846793005u + 1442695040888963407u;
      const auto high = static_cast<float>(seed_ >> 40) * 0x1p-23f;  // 0 ... 2
      a = middle_ + spread_ * (high - 1.0f);
    }
  }

 private:
  float middle_, spread_;
  std::uint64_t seed_ = 1;
};

/// Eight environments of the scenario, as a worker of VecEnv steps them.
class Engine {
 public:
  explicit Engine(int repeats)
      : environment_(
            load_environment({"hover", {"stepping.action_repeat=" + std::to_string(repeats)}, {}})),
        group_(environment_->make_state(kGroup)),
        work_(environment_->make_work(kGroup)),
        observation_(kGroup * kHoverObservation) {
    for (int l = 0; l < kGroup; ++l) {
      environment_->initialize(group_, l, 7, static_cast<std::uint64_t>(l));
    }
    environment_->reset(group_, *work_, kAll, rows());
  }
  void step(const std::vector<float>& actions) {
    environment_->step(group_, *work_, kAll, actions.data(), kHoverActions, rows());
  }
  /// As the limit orders its values: q, u, rotors, target.
  double value(int lane, int k) {
    const Layout& l = environment_->layout();
    if (k < kVelocity) return group_.reals(l.q)[k * kGroup + lane];
    if (k < kRotor) return group_.reals(l.u)[(k - kVelocity) * kGroup + lane];
    if (k < kTarget) return group_.reals(l.rotor_speed)[(k - kRotor) * kGroup + lane];
    return group_.reals(environment_->task().state)[(k - kTarget) * kGroup + lane];
  }
  const float* observation(int lane) const {
    return observation_.data() + static_cast<std::ptrdiff_t>(lane) * kHoverObservation;
  }
  float reward(int lane) const { return reward_[lane]; }

 private:
  static constexpr std::uint32_t kAll = (1u << kGroup) - 1u;
  skybody::Rows rows() { return {observation_.data(), reward_, status_}; }

  std::shared_ptr<const Environment> environment_;
  StateGroup group_;
  std::unique_ptr<GroupWork> work_;
  std::vector<float> observation_;
  float reward_[kGroup] = {};
  std::uint64_t status_[kGroup] = {};
};

void raise(double& largest, double a, double b) {
  largest = std::fmax(largest, std::isnan(a - b) ? INFINITY : std::fabs(a - b));
}

}  // namespace

HoverDifference compare_with_engine(const LoopKind& loop, int repeats, int steps) {
  Engine engine(repeats);
  EnvironmentArray array(loop, kGroup, repeats);
  Actions actions(0.21f, 0.05f);  // about hover, so that no episode ends
  std::vector<float> rows(kGroup * kHoverActions);
  actions.fill(rows);
  array.step(rows.data());  // begins the episodes; then the engine's starts take their place
  for (int e = 0; e < kGroup; ++e) {
    for (int k = 0; k < kStep; ++k) array.value(e, k) = engine.value(e, k);
  }
  for (int n = 0; n < steps; ++n) {
    actions.fill(rows);
    engine.step(rows);
    array.step(rows.data());
  }
  HoverDifference out;
  for (int e = 0; e < kGroup; ++e) {
    for (int k = 0; k < kStep; ++k) {
      const double unit = k >= kRotor && k < kTarget ? 100.0 : 1.0;
      raise(out.state, array.value(e, k) / unit, engine.value(e, k) / unit);
    }
    for (int k = 0; k < kHoverObservation; ++k) {
      raise(out.observation, array.observation(e)[k], engine.observation(e)[k]);
    }
    raise(out.reward, array.reward(e), engine.reward(e));
  }
  return out;
}

bool give_same_rows(const LoopKind& a, const LoopKind& b, int repeats, int rounds) {
  constexpr int kEnvs = 64;
  EnvironmentArray first(a, kEnvs, repeats), second(b, kEnvs, repeats);
  Actions actions(0.2f, 1.0f);
  std::vector<float> rows(kEnvs * kHoverActions);
  for (int n = 0; n < rounds; ++n) {
    actions.fill(rows);
    first.step(rows.data());
    second.step(rows.data());
    for (int e = 0; e < kEnvs; ++e) {
      if (std::memcmp(first.observation(e), second.observation(e),
                      kHoverObservation * sizeof(float)) != 0 ||
          first.reward(e) != second.reward(e) || first.ended(e) != second.ended(e)) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace skybody::bench::limit
