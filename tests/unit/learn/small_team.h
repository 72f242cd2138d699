// A small scenario for learners' tests: two quadrotors in the air with rotor speeds as actions,
// with columns of each robot, one shared column, and a privileged one.
#pragma once

#include <limits>
#include <memory>
#include <string>

#include "core/base/math/random.h"
#include "learn/learner.h"
#include "tests/unit/env/quadrotors_in_the_air.h"

namespace skybody::test {

/// Each robot must keep a random height, common to both; robot k is rewarded k + 1 times as much.
/// @tparam kSpoils  episodes whose height is drawn below a quarter sometimes have a NaN reward
template <bool kSpoils>
class KeepHeight : public Task {
 public:
  struct State {
    double target;
  };

  void configure(const Setup& setup) override {
    setup.channel("target", "m", 1, 0.0, 2.0);
    for (int r = 0; r < 2; ++r) {
      const std::string self = "robot" + std::to_string(r) + ".";
      setup.channel(self + "height", "m", 1, -kInfinity, kInfinity, r);
      setup.channel(self + "speed", "m/s", 1, -kInfinity, kInfinity, r);
      setup.privileged_channel(self + "spin", "rad/s", 3, -kInfinity, kInfinity, r);
    }
    setup.info("position_error", "m", 1);
    setup.robot_rewards();
  }
  void reset(const EnvView<double>& env, State& s) const {
    auto rng = random(env);
    s.target = rng.uniform(0.5, 1.5);
  }
  void evaluate(const EnvView<double>& env, State& s, Evaluation<double>& out) const {
    const bool spoils = kSpoils && s.target < 0.75 && env.step() == 3;
    double worst = 0.0, sum = 0.0;
    out.observation.set(0, s.target);
    for (int r = 0; r < 2; ++r) {
      const BodyMotion<double> b = env.body(r);
      out.observation.set(1 + 2 * r, b.position.z);
      out.observation.set(2 + 2 * r, b.velocity.z);
      out.observation.set(5 + 3 * r, b.angular_velocity.x);
      out.observation.set(6 + 3 * r, b.angular_velocity.y);
      out.observation.set(7 + 3 * r, b.angular_velocity.z);
      const double error = std::abs(b.position.z - s.target);
      worst = std::max(worst, error);
      out.set_reward(r, -error * (r + 1));
      sum -= error * (r + 1);
    }
    out.info.set(0, worst);
    out.set_reward(spoils ? std::numeric_limits<double>::quiet_NaN() : sum);
    out.terminate(worst > 1.0);
  }
};

/// 40 ms per transition, at most 12 per episode.
template <bool kSpoils = false>
std::shared_ptr<const CompiledScenario> small_team() {
  InProcessFactory factory;
  factory.add<Direct>("direct");
  factory.add<KeepHeight<kSpoils>>("keep_height");
  Scenario s = empty_air("small_team");
  s.stepping.dt = 0.004;
  s.stepping.action_repeat = 10;
  for (int r = 0; r < 2; ++r) {
    s.robots.push_back(quadrotor_at(5.0 * r, "quad" + std::to_string(r), factory));
  }
  s.task = factory.use("keep_height", "task");
  return std::make_shared<CompiledScenario>(s, factory);
}

/// A quick learner on it: 19 environments, minibatches that divide no row count evenly.
inline learn::LearnerOptions small_options(std::shared_ptr<const CompiledScenario> compiled) {
  learn::LearnerOptions options;
  options.compiled = std::move(compiled);
  options.seed = 7;
  options.total_steps = 4000;
  options.threads = 1;
  options.hyper.envs = 19;
  options.hyper.rollout_steps = 10;
  options.hyper.minibatch = 48;
  options.hyper.value_epochs = 2;
  options.hyper.hidden = {16, 16};
  options.hyper.final_log_std = -2.0;
  options.hyper.averaging_steps = 600.0;
  return options;
}

}  // namespace skybody::test
