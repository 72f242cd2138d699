// The tree's algorithms behind the interface of Simbody's dynamics, for comparison.
#pragma once

#include <memory>
#include <vector>

#include "core/physics/tree/multibody_tree.h"
#include "tests/unit/physics/uncoupled_dynamics.h"

namespace skybody::test {

class TreeDynamics final : public UncoupledDynamics {
 public:
  explicit TreeDynamics(const World& world)
      : world_(world),
        forest_(world),
        constants_(kBodyConstantCount * world.bodies.size()),
        motion_(world.bodies.size()),
        body_(world.bodies.size()),
        ball_(world.bodies.size()),
        acceleration_(world.bodies.size()) {
    TreeDynamics::set_params(world.layout.nominal_params().data());
  }

  void set_params(const double* params) override {
    make_body_constants(world_, params, constants_.data());
  }
  void accelerations(const double* q, const double* u, const SpatialForce<double>* body_forces,
                     const double* joint_forces, double* udot) override {
    forward_kinematics(forest_.bodies(), q, u, motion_.data());
    const double* constants = constants_.data();
    forest_.accelerations(
        q, u, motion_.data(), constants, body_forces, joint_forces,
        MultibodyTree::Work<double>{body_.data(), ball_.data(), acceleration_.data()}, udot);
  }
  void body_states(const double* q, const double* u, BodyState* bodies) override {
    forward_kinematics(forest_.bodies(), q, u, motion_.data());
    for (std::size_t i = 0; i < motion_.size(); ++i) bodies[i] = to_body_state(motion_[i]);
  }

 private:
  const World& world_;
  MultibodyTree forest_;
  std::vector<double> constants_;
  std::vector<BodyKinematics<double>> motion_;
  std::vector<ArticulatedBodyCache<double>> body_;
  std::vector<BallJointCache<double>> ball_;
  std::vector<SpatialAcceleration<double>> acceleration_;
};

inline std::unique_ptr<Dynamics> make_tree_dynamics(const World& world) {
  return std::make_unique<TreeDynamics>(world);
}
inline std::unique_ptr<Dynamics> make_nominal_simbody(const World& world) {
  return make_simbody_dynamics(world, world.layout.nominal_params().data());
}

}  // namespace skybody::test
