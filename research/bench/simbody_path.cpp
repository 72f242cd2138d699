// Cost of the engine over Simbody, in one run, taking turns: two hand-written loops over
// the same hover world, our physics only (GroupStepper), and the whole environment step of
// scenarios/hover/hover.yaml (action, plugins, physics, observation, reward, ends) on `dynamics:
// simbody`. Exit code 1 if the first three end in different states. --trial: once and short, for
// tests.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <vector>

#include "core/env/group_workspace.h"
#include "core/physics/bodies/default_state.h"
#include "core/physics/step/group_stepper.h"
#include "core/simulation/simulation.h"
#include "research/bench/bare_simbody.h"

namespace skybody::bench {
namespace {

/// Length of the measurement.
struct Length {
  int trials = 15, steps = 20000;
};

Scenario make_hover() {
  Body base;
  base.name = "base";
  base.mass = {
      kHover.mass, {0, 0, 0}, {kHover.inertia[0], kHover.inertia[1], kHover.inertia[2], 0, 0, 0}};
  Shape box;
  box.type = ShapeType::kBox;
  box.size = {0.3, 0.3, 0.1};
  base.collisions.push_back(box);
  RobotUse robot;
  robot.name = "quad";
  robot.pose.position = {0, 0, kHover.height};
  robot.rotor_speed = kHover.start;
  robot.model.bodies.push_back(base);
  for (int i = 0; i < 4; ++i) {
    Rotor rotor;
    rotor.set_position({kHover.hub[i][0], kHover.hub[i][1], 0});
    rotor.direction = kHover.direction[i];
    rotor.constants[kThrustConstant] = kHover.kf;
    rotor.constants[kMomentConstant] = kHover.km;
    rotor.constants[kMaxSpeed] = kHover.max_speed;
    rotor.constants[kTauUp] = kHover.tau_up;
    rotor.constants[kTauDown] = kHover.tau_down;
    robot.model.rotors.push_back(rotor);
  }
  Scenario scenario;
  scenario.robots.push_back(robot);
  return scenario;
}

/// The engine's physics only.
class Physics {
 public:
  Physics()
      : world_(make_hover()),
        physics_(world_, DynamicsBackend::kSimbody),
        stepper_(physics_.make_stepper(1)),
        scratch_(physics_.make_scratch()) {
    write_default_state(world_, state_);
    state_.rotor_command.assign(4, kHover.command);
    for (const InputBlock& block : kInputBlocks) {
      group_.*block.values = values_of(state_, block.place).data();
    }
    for (const StateBlock& block : kStateBlocks) {
      group_.*block.values = values_of(state_, block.place).data();
    }
    group_.bodies = reinterpret_cast<double*>(state_.bodies.data());
    stepper_->refresh(group_, 1u, 1u, scratch_);
  }
  void step() { ok_ = stepper_->advance(group_, 1u, scratch_) != 0 && ok_; }
  double height() const { return ok_ ? state_.q[2] : -1.0; }

 private:
  World world_;
  GroupPhysics physics_;
  std::unique_ptr<GroupStepper> stepper_;
  PhysicsScratch scratch_;
  LaneState state_;
  GroupBlocks group_;
  bool ok_ = true;
};

/// The whole environment step, as in Simulation and a batch (without the trajectory hash).
class Whole {
 public:
  Whole()
      : compiled_(compile_scenario({"hover", {"stepping.dynamics=simbody"}, {}})),
        group_(compiled_->make_state(1)),
        work_(compiled_->make_workspace(1)),
        observation_(static_cast<std::size_t>(compiled_->observation_size())),
        // 1391 rad/s of 2300
        action_(static_cast<std::size_t>(compiled_->action_size()),
                2.0f * 1391.0f / 2300.0f - 1.0f) {
    compiled_->initialize(group_, 0, 1, 0);
    compiled_->reset(group_, *work_, 1u, rows());
  }
  void step() {
    compiled_->step(group_, *work_, 1u, action_.data(), compiled_->action_size(), rows());
    if (status_ != kRunning) compiled_->reset(group_, *work_, 1u, rows());
  }
  double height() const { return 0.0; }

 private:
  Rows rows() { return {observation_.data(), &reward_, &status_}; }
  std::shared_ptr<const CompiledScenario> compiled_;
  StateGroup group_;
  std::unique_ptr<GroupWorkspace> work_;
  std::vector<float> observation_, action_;
  float reward_ = 0.0f;
  std::uint64_t status_ = 0;
};

/// @returns nanoseconds per step, and the final position of the vehicle
template <class Loop>
double measure(Loop& loop, int steps, double& height) {
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < steps; ++i) loop.step();
  const std::chrono::duration<double, std::nano> time = std::chrono::steady_clock::now() - start;
  height = loop.height();
  return time.count() / steps;
}

int run(const Length& length) {
  double best[4] = {1e300, 1e300, 1e300, 1e300}, height[4] = {};
  for (int trial = 0; trial < length.trials; ++trial) {
    const auto forces = make_bare_loop(false), with_operator = make_bare_loop(true);
    Physics physics;
    Whole whole;
    best[0] = std::min(best[0], measure(*forces, length.steps, height[0]));
    best[1] = std::min(best[1], measure(*with_operator, length.steps, height[1]));
    best[2] = std::min(best[2], measure(physics, length.steps, height[2]));
    best[3] = std::min(best[3], measure(whole, length.steps, height[3]));
  }
  std::printf("one hovering QDrone2, midpoint at 1 ms, best of %d x %d steps\n", length.trials,
              length.steps);
  const char* names[4] = {"bare Simbody, forces", "bare Simbody, operator", "our physics",
                          "whole environment step"};
  for (int i = 0; i < 4; ++i) {
    std::printf("  %-24s %7.0f ns a step = %.2f of the first, %.2f of the second\n", names[i],
                best[i], best[i] / best[0], best[i] / best[1]);
  }
  const bool agree =
      std::fabs(height[0] - height[2]) < 1e-6 && std::fabs(height[1] - height[2]) < 1e-6;
  if (!agree) std::printf("they disagree: %.9f %.9f %.9f m\n", height[0], height[1], height[2]);
  return agree ? 0 : 1;
}

}  // namespace
}  // namespace skybody::bench

int main(int argc, char** argv) {
  skybody::bench::Length length;
  if (argc > 1 && std::strcmp(argv[1], "--trial") == 0) length = {1, 200};
  return skybody::bench::run(length);
}
