// Accelerations of bodies against the difference of forward kinematics, over every kind of joint.
#include "core/physics/bodies/body_accelerations.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/math/random.h"

namespace skybody {
namespace {

/// A chain of one body on every kind of joint, with rotated and offset frames on parent and body.
std::vector<TreeBody> chain_of_all_joints(int& q_count, int& u_count) {
  std::vector<TreeBody> tree;
  q_count = u_count = 0;
  for (const JointType type : {JointType::kFree, JointType::kPin, JointType::kUniversal,
                               JointType::kSlider, JointType::kBall, JointType::kWeld}) {
    TreeBody body;
    body.type = type;
    body.parent = static_cast<int>(tree.size()) - 1;
    body.q = q_count;
    body.u = u_count;
    if (body.parent >= 0) {
      body.plain_parent = body.plain_body = false;
      body.frame_in_parent = {{0.3, -0.1, 0.2}, normalized(Quat<double>{0.9, 0.3, -0.2, 0.1})};
      body.frame_in_body = {{-0.2, 0.15, 0.05}, normalized(Quat<double>{0.8, -0.1, 0.4, 0.3})};
    }
    q_count += position_size(type);
    u_count += velocity_size(type);
    tree.push_back(body);
  }
  return tree;
}

TEST(BodyAccelerations, AreTheDerivativeOfForwardKinematicsForEveryJoint) {
  int q_count, u_count;
  const std::vector<TreeBody> tree = chain_of_all_joints(q_count, u_count);
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    Random<double> rng({7, trial}, 0, 0, 0);
    const auto draw = [&](int count) {
      std::vector<double> values;
      for (int k = 0; k < count; ++k) values.push_back(rng.uniform(-2.0, 2.0));
      return values;
    };
    std::vector<double> q = draw(q_count);
    const std::vector<double> u = draw(u_count), udot = draw(u_count);
    std::vector<double> qdot(q.size());
    for (const TreeBody& body : tree) {
      normalize_position(body.type, q.data() + body.q);
      position_rates(body.type, q.data() + body.q, u.data() + body.u, qdot.data() + body.q);
    }
    const double h = 1e-5;
    const auto motion_at = [&](double t) {
      std::vector<double> q_t = q, u_t = u;
      for (std::size_t k = 0; k < q.size(); ++k) q_t[k] += t * qdot[k];
      for (std::size_t k = 0; k < u.size(); ++k) u_t[k] += t * udot[k];
      std::vector<BodyKinematics<double>> motion(tree.size());
      forward_kinematics(tree, q_t.data(), u_t.data(), motion.data());
      return motion;
    };
    const auto before = motion_at(-h), after = motion_at(h);
    const auto found = body_accelerations(tree, q.data(), u.data(), udot.data());
    for (std::size_t i = 0; i < tree.size(); ++i) {
      const BodyState a = to_body_state(before[i]), b = to_body_state(after[i]);
      const Vec3<double> linear = (b.velocity - a.velocity) / (2 * h);
      const Vec3<double> angular = (b.angular_velocity - a.angular_velocity) / (2 * h);
      // Central differences: h^2 / 6 times a third derivative of some 1e3 along the chain, and
      // rounding of 1e-15 / h: both below 1e-7. Straight steps in q leave the curve of the motion
      // only to second order, which central differences cancel.
      EXPECT_NEAR(norm(linear - found[i].linear), 0.0, 1e-6) << trial << " body " << i;
      EXPECT_NEAR(norm(angular - found[i].angular), 0.0, 1e-6) << trial << " body " << i;
    }
  }
}

}  // namespace
}  // namespace skybody
