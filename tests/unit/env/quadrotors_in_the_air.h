// Scenarios shared by the tests of the engine and the learners: quadrotors in the air with rotor
// speeds as actions.
#pragma once

#include <string>

#include "tests/unit/env/in_process_factory.h"

namespace skybody::test {

/// Rotor speeds directly from the action, 0 to 3400 rad/s: an action of 0 climbs slightly.
class Direct : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kRotorSpeed, {0, 0, 0, 0}, {3400, 3400, 3400, 3400});
    setup.output(Signal::kRotorSpeed, 4);
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> in, Values<Real> out) const {
    for (int i = 0; i < 4; ++i) out.set(i, in[i]);
  }
};

/// No robots, no ground, and at most 12 transitions per episode.
inline Scenario empty_air(const std::string& name) {
  Scenario s;
  s.name = name;
  s.file = name + ".yaml";
  s.hash = 1;
  s.stepping.horizon = 12;
  s.contact.ground = false;
  return s;
}

/// A quadrotor at a height of 1 m with a Direct controller.
/// @param factory  provides it as `direct`
inline RobotUse quadrotor_at(double x, const std::string& name, const InProcessFactory& factory) {
  RobotUse robot;
  robot.name = name;
  robot.model = quadrotor();
  robot.pose.position = {x, 0.0, 1.0};
  robot.controllers.push_back(factory.use("direct", name + "_direct"));
  return robot;
}

}  // namespace skybody::test
