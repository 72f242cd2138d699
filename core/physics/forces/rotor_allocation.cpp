// As in core/base/math/inertia.cpp: the library has one form of each of Eigen's functions.
#define EIGEN_DONT_VECTORIZE
#include "core/physics/forces/rotor_allocation.h"

#include <Eigen/LU>

#include "core/physics/forces/rotor_force.h"

namespace skybody {
namespace {

using RowMatrixX4 = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;

}  // namespace

std::vector<double> allocation_of(const World& world, int robot,
                                  const std::vector<double>& params) {
  const RobotModel& model = world.scenario.robots[static_cast<std::size_t>(robot)].model;
  const RobotLayout& layout = world.layout.robots[static_cast<std::size_t>(robot)];
  const auto values_of = [&](const std::vector<int>& firsts, int index) {
    return params.data() + firsts[static_cast<std::size_t>(index)];
  };
  const double* base = values_of(world.layout.body_params, layout.first_body);
  const Vec3<double> com{base[kCom], base[kCom + 1], base[kCom + 2]};
  if (model.rotors.size() < 4) return {};
  const auto rotors = static_cast<Eigen::Index>(model.rotors.size());
  Eigen::Matrix4Xd effect(4, rotors);  // force and torque of each rotor at a thrust of 1 N
  for (Eigen::Index k = 0; k < rotors; ++k) {
    const Rotor& r = model.rotors[static_cast<std::size_t>(k)];
    if (r.body != 0) return {};
    constexpr double kLevel = -1e-6;  // of an axis, up to round-off
    if (r.axis.z <= kLevel && !r.is_reversible()) {
      effect.col(k).setZero();
      continue;
    }
    const double* constants =
        values_of(world.layout.rotor_params, layout.first_rotor + static_cast<int>(k));
    const Vec3<double> arm = hub_of<double>(constants) - com;
    const Vec3<double> torque =
        cross(arm, r.axis) -
        (r.direction * constants[kMomentConstant] / constants[kThrustConstant]) * r.axis;
    effect.col(k) << r.axis.z, torque.x, torque.y, torque.z;
  }
  // Torques are a tenth of thrusts: scaled rows keep the singularity test meaningful.
  const Eigen::Vector4d scale(1.0, 1.0 / 0.1, 1.0 / 0.1, 1.0 / 0.01);
  const Eigen::Matrix4Xd scaled = scale.asDiagonal() * effect;
  Eigen::FullPivLU<Eigen::Matrix4d> product(scaled * scaled.transpose());
  product.setThreshold(1e-12);
  if (!product.isInvertible()) return {};
  const RowMatrixX4 allocation = scaled.transpose() * product.inverse() * scale.asDiagonal();
  return {allocation.data(), allocation.data() + allocation.size()};
}

std::string allocation_obstacle(const World& world, int robot) {
  const RobotModel& model = world.scenario.robots[static_cast<std::size_t>(robot)].model;
  if (model.rotors.size() < 4) {
    return "it has " + std::to_string(model.rotors.size()) + " rotors, and 4 are needed";
  }
  for (const Rotor& rotor : model.rotors) {
    if (rotor.body == 0) continue;
    const Body& body = model.bodies[static_cast<std::size_t>(rotor.body)];
    return "its rotor `" + rotor.name + "` sits behind the joint `" + body.joint.name +
           "`, which turns the thrust away from the base";
  }
  const bool reaches = !allocation_of(world, robot, world.layout.nominal_params()).empty();
  return reaches ? "" : "its rotors do not give thrust and all three torques";
}

}  // namespace skybody
