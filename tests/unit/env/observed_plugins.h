// A sensor and tasks for tests of the observation's columns.
#pragma once

#include <limits>

#include "tests/unit/env/small_plugins.h"

namespace skybody::test {

/// Height and velocity, and the physics step for a critic; not finite from a given physics step on.
class Gauge : public Sensor {
 public:
  RealParameter breaks_at{
      this,
      {.name = "breaks_at", .value = 1e9, .min = 0.0, .doc = "physics step", .randomizable = true}};

  void configure(const Setup& setup) override {
    setup.channel("height", "m", 1, 0.0, 100.0);
    setup.channel("velocity", "m/s", 3, -kInfinity, kInfinity, 0);
    setup.privileged_channel("step", "", 1, 0.0, kInfinity);
  }
  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>&, Values<Real> out) const {
    const BodyMotion<Real> b = env.body(0);
    const Real step = to_real(env.physics_step());
    out.set(0, b.position.z);
    out.set(1, b.velocity);
    const Real nan(std::numeric_limits<double>::quiet_NaN());
    out.set(4, select(step < breaks_at(env), step, nan));
  }
};

/// Observes its height; a critic also receives the vertical speed, and the policy a constant 1
/// after it.
class Critic : public Task {
 public:
  void configure(const Setup& setup) override {
    setup.channel("height", "m", 1, -kInfinity, kInfinity);
    setup.privileged_channel("vertical_speed", "m/s", 1, -kInfinity, kInfinity);
    setup.channel("one", "", 1, 1, 1);
  }
  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out) const {
    out.observation.set(0, env.body(0).position.z);
    out.observation.set(1, env.body(0).velocity.z);
    out.observation.set(2, Real(1.0));
  }
};

/// Gives a policy no observation.
class Blind : public Task {
 public:
  void configure(const Setup& setup) override {
    setup.privileged_channel("height", "m", 1, -kInfinity, kInfinity);
  }
  template <class Real>
  void evaluate(const EnvView<Real>&, State<Real>&, Evaluation<Real>&) const {}
};

/// Outputs a velocity twice, after a height; packs omit the copy.
/// @tparam kTo, kFrom  declared offset of the copy, and of its source
/// @tparam kMiddle     true: the critic's value lies between them; false: after them
template <int kTo, int kFrom, bool kMiddle = false>
class Mirror : public Task {
 public:
  void configure(const Setup& setup) override {
    setup.channel("height", "m", 1, -kInfinity, kInfinity);
    setup.channel("velocity", "m/s", 3, -kInfinity, kInfinity);
    if (kMiddle) setup.privileged_channel("one", "", 1, 1, 1);
    setup.channel("again", "m/s", 3, -kInfinity, kInfinity);
    if (!kMiddle) setup.privileged_channel("one", "", 1, 1, 1);
    setup.repeat(kTo, kFrom, 3);
  }
  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out) const {
    constexpr int kAgain = kMiddle ? 5 : 4;
    out.observation.set(0, env.body(0).position.z);
    out.observation.set(1, env.body(0).velocity);
    out.observation.set(kMiddle ? 4 : 7, Real(1.0));
    if constexpr (!kLeavesRepeats<Real>) out.observation.set(kAgain, env.body(0).velocity);
  }
};

/// Uses one name twice.
class Twice : public Sensor {
 public:
  void configure(const Setup& setup) override {
    setup.channel("height", "m", 1, -kInfinity, kInfinity);
    setup.channel("height", "m", 1, -kInfinity, kInfinity);
  }
  template <class Real>
  void sense(const EnvView<Real>&, State<Real>&, Values<Real>) const {}
};

}  // namespace skybody::test
