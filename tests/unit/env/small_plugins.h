// Plugins inside the test program, small enough to record the inputs of each phase.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/math/math.h"
#include "tests/unit/env/in_process_factory.h"

namespace skybody::test {

/// Rotor speeds directly from the action, 0 to 4000 rad/s; counts its calls and records its inputs.
class Direct : public Controller {
 public:
  template <class Real>
  struct State {
    Real calls, last_height;
    Word<Real> last_physics_step;
  };
  RealParameter scale{this,
                      {.name = "scale",
                       .value = 1.0,
                       .min = 0.5,
                       .max = 2.0,
                       .doc = "factor",
                       .randomizable = true}};

  void configure(const Setup& setup) override {
    const int n = setup.rotors_of(setup.robot()).size();
    setup.input(Signal::kRotorSpeed, std::vector<double>(static_cast<std::size_t>(n), 0.0),
                std::vector<double>(static_cast<std::size_t>(n), 4000.0));
    setup.output(Signal::kRotorSpeed, n);
    body_ = setup.robots()[setup.robot()].first_body;
    count_ = n;
  }
  template <class Real>
  void control(const EnvView<Real>& env, State<Real>& s, ConstValues<Real> in,
               Values<Real> out) const {
    s.calls += Real(1.0);
    s.last_height = env.body(body_).position.z;
    s.last_physics_step = env.physics_step();
    for (int i = 0; i < count_; ++i) out.set(i, in[i] * scale(env));
  }

 private:
  int body_ = 0, count_ = 0;
};

/// The same, written for plain double.
class PlainDirect : public Controller {
 public:
  struct State {
    double calls, last_height;
    std::uint64_t last_physics_step;
  };
  void configure(const Setup& setup) override {
    setup.input(Signal::kRotorSpeed, {0, 0, 0, 0}, {4000, 4000, 4000, 4000});
    setup.output(Signal::kRotorSpeed, 4);
  }
  void control(const EnvView<double>& env, State& s, ConstValues<double> in,
               Values<double> out) const {
    s.calls += 1.0;
    s.last_height = env.body(0).position.z;
    s.last_physics_step = env.physics_step();
    for (int i = 0; i < 4; ++i) out.set(i, in[i]);
  }
};

/// Sets the controller's scale from the robot's position: outdated bodies would be detected.
class Look : public Randomizer {
 public:
  void configure(const Setup& setup) override {
    param_ = setup.find_params("controllers.direct.scale")[0];
    setup.writes(param_);
  }
  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>&, Start<Real>& start) const {
    start.params.set(param_, env.body(0).position.z);
  }

 private:
  int param_ = 0;
};

/// Declares a wrench at a body that does not exist.
class LostSite : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kWrench, std::vector<double>(6, -1.0), std::vector<double>(6, 1.0));
    setup.output(Signal::kWrench, 6);
    setup.site({7, {0, 0, 0}, 1, 1});
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real>, Values<Real>) const {}
};

/// Outputs a signal that no actuator takes.
class Dangling : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kCtbt, {0, 0, 0, 0}, {1, 1, 1, 1});
    setup.output(Signal::kSrt, 4);
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real>, Values<Real>) const {}
};

/// Observes height, vertical speed, physics step and a draw; ends below the ground.
class Watch : public Task {
 public:
  template <class Real>
  struct State {
    Real drawn;
  };
  void configure(const Setup& setup) override {
    setup.channel("height", "m", 1, -kInfinity, kInfinity);
    setup.channel("vertical_speed", "m/s", 1, -kInfinity, kInfinity);
    setup.channel("physics_step", "", 1, 0, kInfinity);
    setup.channel("drawn", "", 1, 0, 1);
  }
  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& s) const {
    auto rng = random(env);
    s.drawn = rng.uniform();
  }
  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>& s, Evaluation<Real>& out) const {
    const BodyMotion<Real> b = env.body(0);
    out.observation.set(0, b.position.z);
    out.observation.set(1, b.velocity.z);
    out.observation.set(2, to_real(env.physics_step()));
    out.observation.set(3, s.drawn);
    out.set_reward(b.position.z);
    out.terminate(b.position.z < Real(-1.0));
  }
};

/// Gives the robot a velocity, and sets the controller's scale far out of its bounds every second
/// reset.
class Kick : public Randomizer {
 public:
  template <class Real>
  struct State {
    Word<Real> resets;
  };
  void configure(const Setup& setup) override {
    param_ = setup.find_params("controllers.direct.scale")[0];
    setup.writes(param_);
  }
  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>& s, Start<Real>& start) const {
    auto rng = random(env);
    start.u.set(0, rng.uniform(Real(-1.0), Real(1.0)));
    start.params.set(param_, rng.uniform(Real(0.0), Real(4.0)));
    s.resets = s.resets + Word<Real>(1);
  }

 private:
  int param_ = 0;
};

}  // namespace skybody::test
