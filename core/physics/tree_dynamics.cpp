#include "core/physics/tree_dynamics.h"

#include <cstring>
#include <vector>

#include "core/base/error.h"
#include "core/physics/tree_accelerations.h"

namespace skybody {
namespace {

class TreeDynamics final : public Dynamics {
 public:
  explicit TreeDynamics(const World& world)
      : world_(world),
        forest_(world),
        constants_(kBodyConstantCount * world.bodies.size()),
        motion_(world.bodies.size()),
        body_(world.bodies.size()),
        ball_(world.bodies.size()),
        acceleration_(world.bodies.size()) {
    std::vector<double> nominal;
    for (const EnvParam& param : world.layout.param_info) nominal.push_back(param.nominal);
    set_params(nominal.data());
  }

  void set_params(const double* params) override {
    // The mass properties of all bodies lie one after another (world_layout.cpp).
    const double* mine = params + world_.layout.body_params.front();
    const std::size_t count = kBodyParamCount * world_.bodies.size();
    if (!made_from_.empty() && std::memcmp(mine, made_from_.data(), count * sizeof(double)) == 0) {
      return;
    }
    made_from_.clear();
    make_body_constants(world_, params, constants_.data());
    made_from_.assign(mine, mine + count);
  }

  void accelerations(const double* q, const double* u, const SpatialForce<double>* body_forces,
                     const double* joint_forces, double* udot) override {
    forward_kinematics(forest_.bodies(), q, u, motion_.data());
    forest_.accelerations<double, const double*>(
        q, u, motion_.data(), constants_.data(), body_forces, joint_forces,
        {body_.data(), ball_.data(), acceleration_.data()}, udot);
  }

  void body_states(const double* q, const double* u, BodyState* bodies) override {
    forward_kinematics(forest_.bodies(), q, u, motion_.data());
    for (std::size_t i = 0; i < motion_.size(); ++i) bodies[i] = to_body_state(motion_[i]);
  }

 private:
  const World& world_;
  Forest forest_;
  std::vector<double> made_from_;  ///< parameters that `constants_` belong to; empty: none
  std::vector<double> constants_;
  std::vector<BodyKinematics<double>> motion_;
  std::vector<TreeBodyWork<double>> body_;
  std::vector<BallJointWork<double>> ball_;
  std::vector<SpatialAcceleration<double>> acceleration_;
};

}  // namespace

std::string why_not_tree(const World& world) {
  const std::vector<RobotUse>& robots = world.scenario.robots;
  if (robots.size() != 1) return "has " + std::to_string(robots.size()) + " robots";
  if (!world.scenario.obstacles.empty()) return "has obstacles";
  return "";
}

std::unique_ptr<Dynamics> make_tree_dynamics(const World& world) {
  return std::make_unique<TreeDynamics>(world);
}

}  // namespace skybody
