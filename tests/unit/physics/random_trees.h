// Random robots: trees of one to six bodies with every kind of joint, and states for them.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/math/random.h"
#include "core/physics/bodies/kinematics.h"
#include "tests/unit/physics/test_models.h"

namespace skybody::test {

inline Vec3<double> in_cube(Random<double>& random, double half_edge) {
  const auto next = [&] { return random.uniform(-half_edge, half_edge); };
  const double x = next(), y = next(), z = next();
  return {x, y, z};
}

/// Log-uniform between two values. Avoids libm, whose last bits differ between machines.
inline double log_uniform(Random<double>& random, double low, double high) {
  return low * exp(random.uniform() * log(high / low));
}

/// From 10 g in 2 cm to 50 kg in 1 m; flat, long and compact ones, on rotated axes, the centre of
/// mass anywhere within the body's size.
inline MassProperties random_mass(Random<double>& random) {
  const double size = log_uniform(random, 0.02, 1.0);
  MassProperties mass;
  mass.mass = log_uniform(random, 0.01, 50.0);
  mass.com = in_cube(random, size);
  const double scale = mass.mass * size * size;
  const auto spread = [&] { return scale * random.uniform(0.02, 0.3); };  // integrals of x^2 dm
  const double x = spread(), y = spread(), z = spread();
  mass.inertia =
      rotate_inertia(to_mat3(random.quaternion()), SymMat3<double>{y + z, x + z, x + y, 0, 0, 0});
  return mass;
}

/// Position and rotation, each or both or neither: code may skip identity parts.
inline Pose random_frame(Random<double>& random) {
  Pose frame;
  if (random.uniform() < 0.6) frame.position = in_cube(random, 0.3);
  if (random.uniform() < 0.6) frame.rotation = random.quaternion();
  return frame;
}

/// Free in most cases; otherwise fixed, or on any joint.
inline JointType random_root(Random<double>& random) {
  const double draw = random.uniform();
  if (draw < 0.6) return JointType::kFree;
  if (draw < 0.75) return JointType::kWeld;
  return static_cast<JointType>(static_cast<int>(JointType::kPin) +
                                static_cast<int>((draw - 0.75) * 16.0));
}

/// A base, and up to five more bodies on joints anywhere in the tree.
inline RobotModel random_tree(Random<double>& random) {
  RobotModel model;
  model.name = "tree";
  const int bodies = 1 + static_cast<int>(random.uniform() * 6.0);
  for (int i = 0; i < bodies; ++i) {
    const JointType type = i == 0
                               ? random_root(random)
                               : static_cast<JointType>(static_cast<int>(JointType::kPin) +
                                                        static_cast<int>(random.uniform() * 4.0));
    const MassProperties mass = random_mass(random);
    const int parent = i == 0 ? -1 : static_cast<int>(random.uniform() * i);
    Body body = make_body("b" + std::to_string(i), type, parent, mass.mass, mass.com, mass.inertia);
    if (type != JointType::kFree) {
      body.joint.frame_in_parent = random_frame(random);
      body.joint.frame_in_body = random_frame(random);
    }
    model.bodies.push_back(body);
  }
  return model;
}

/// Random coordinates and rates of all joints; quaternions have norm 1.
inline void random_state(Random<double>& random, const World& world, std::vector<double>& q,
                         std::vector<double>& u) {
  for (const TreeBody& body : make_tree(world)) {
    double* at = q.data() + body.q;
    if (body.type == JointType::kFree) {
      store(in_cube(random, 10.0), at);
      store(random.quaternion(), at + 3);
    } else if (body.type == JointType::kBall) {
      store(random.quaternion(), at);
    } else {
      for (int k = 0; k < position_size(body.type); ++k) at[k] = random.uniform(-3.0, 3.0);
    }
  }
  for (double& rate : u) rate = random.uniform(-5.0, 5.0);
}

inline std::vector<double> nominal_params(const World& world) {
  std::vector<double> params;
  for (const EnvParam& param : world.layout.param_info) params.push_back(param.nominal);
  return params;
}

inline double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double v : values) most = std::max(most, std::abs(v));
  return most;
}
inline double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

}  // namespace skybody::test
