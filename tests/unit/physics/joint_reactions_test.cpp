// Reactions of joints against virtual work: along a joint's degrees of freedom its reaction is the
// joint's own force and nothing else. Accelerations are Simbody's, over random trees.
#include "core/physics/bodies/joint_reactions.h"

#include <gtest/gtest.h>

#include "tests/unit/physics/random_trees.h"
#include "tests/unit/physics/tree_dynamics.h"

namespace skybody::test {
namespace {

/// A tree at a random state under random forces, with the reactions of its joints.
struct Moment {
  Moment(const World& world, Random<double>& random)
      : tree(make_tree(world)),
        q(static_cast<std::size_t>(world.layout.q.size)),
        u(static_cast<std::size_t>(world.layout.u.size)),
        joint_forces(u.size()),
        udot(u.size()),
        loads(world.bodies.size()),
        reactions(world.bodies.size()) {
    random_state(random, world, q, u);
    for (double& f : joint_forces) f = random.uniform(-1.0, 1.0);
    for (SpatialForce<double>& f : loads) f = {in_cube(random, 1.0), in_cube(random, 5.0)};
    const std::vector<double> params = nominal_params(world);
    make_nominal_simbody(world)->accelerations(q.data(), u.data(), loads.data(),
                                               joint_forces.data(), udot.data());
    std::vector<BodyKinematics<double>> motion(tree.size());
    std::vector<BodyAcceleration> accelerations(tree.size());
    forward_kinematics(tree, q.data(), u.data(), motion.data());
    body_accelerations(tree, q.data(), u.data(), udot.data(), motion.data(), accelerations.data());
    joint_reactions(world, params.data(), motion.data(), accelerations.data(), loads.data(),
                    reactions.data());
  }

  /// Work of a body's reaction if only coordinate `k` of its joint moves, with rate 1.
  double work(std::size_t body, int k) const {
    std::vector<double> rate(u.size(), 0.0);
    rate[static_cast<std::size_t>(tree[body].u + k)] = 1.0;
    std::vector<BodyKinematics<double>> motion(tree.size());
    forward_kinematics(tree, q.data(), rate.data(), motion.data());
    return dot(reactions[body].force, motion[body].velocity) +
           dot(reactions[body].moment, motion[body].angular_velocity);
  }

  std::vector<TreeBody> tree;
  std::vector<double> q, u, joint_forces, udot;
  std::vector<SpatialForce<double>> loads, reactions;
};

TEST(JointReactions, DoTheWorkOfTheJointsOwnForceInItsFreeDirections) {
  int compared = 0;
  for (std::uint64_t trial = 0; trial < 500; ++trial) {
    Random<double> random(RandomKey{2026, 11}, trial, 0, derive_stream("joint_reactions_test"));
    const World world(make_scenario(random_tree(random)));
    const Moment moment(world, random);
    double size = 1.0;
    for (const SpatialForce<double>& f : moment.reactions) {
      size = std::max({size, norm(f.force), norm(f.moment)});
    }
    for (std::size_t i = 0; i < moment.tree.size(); ++i) {
      for (int k = 0; k < velocity_size(moment.tree[i].type); ++k) {
        const double expected = moment.joint_forces[static_cast<std::size_t>(moment.tree[i].u + k)];
        // Simbody's accelerations have a relative error of some 1e-10 near singular trees.
        EXPECT_NEAR(moment.work(i, k), expected, 1e-8 * size) << trial << " body " << i;
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 2000);
}

}  // namespace
}  // namespace skybody::test
