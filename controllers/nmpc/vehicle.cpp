#include "controllers/nmpc/vehicle.h"

#include <Eigen/QR>
#include <string>

#include "controllers/common/allocation.h"

namespace skybody::nmpc {
namespace {

/// Rotors about the base's centre of mass, by acceleration and angular acceleration at full thrust.
void set_rotors(const Setup& setup, int robot, double mass, Model& model) {
  const View<RotorInfo> rotors = control::working_rotors(setup, robot, "nmpc");
  const BodyInfo& base = setup.bodies()[control::base_of(setup, robot)];
  if (rotors.size() > kMostRotors) {
    throw std::runtime_error("robot `" + control::robot_name(setup, robot) + "` has " +
                             std::to_string(rotors.size()) + " rotors; nmpc takes up to " +
                             std::to_string(kMostRotors) + ": use another controller");
  }
  model.rotors = rotors.size();
  for (int i = 0; i < rotors.size(); ++i) {
    const RotorInfo& rotor = rotors[i];
    if (rotor.body != control::base_of(setup, robot)) {
      throw std::runtime_error("rotor `" + std::string(rotor.name) + "` sits behind a joint, on `" +
                               setup.bodies()[rotor.body].name +
                               "`; nmpc needs rotors fixed to the base: use controller `srt`");
    }
    const double full = control::full_thrust(rotor);
    model.rotor[i] = {control::vec3(rotor.axis) * (full / mass),
                      model.inverse_inertia * (control::effect_of(rotor, base).torque * full),
                      rotor.constants[SKYBODY_ROTOR_TAU_UP],
                      rotor.constants[SKYBODY_ROTOR_TAU_DOWN]};
  }
}

/// Drag of the rotors, k_d w (v - (v . n) n) each, at the speeds that hold the weight: the part
/// along each base axis, per mass.
void set_drag(const Setup& setup, int robot, double mass, Model& model) {
  double lift = 0.0;
  for (int i = 0; i < model.rotors; ++i) lift += max(0.0, model.rotor[i].acceleration.z);
  const double share = clamp(norm(model.gravity) / lift, 0.0, 1.0);
  for (const RotorInfo& rotor : setup.rotors_of(robot)) {
    const double speed = rotor.constants[SKYBODY_ROTOR_MAX_SPEED] * sqrt(share);
    const double drag = rotor.constants[SKYBODY_ROTOR_DRAG_CONSTANT] * speed / mass;
    const Vec3<double> n = control::vec3(rotor.axis);
    model.drag += Vec3<double>{1.0 - n.x * n.x, 1.0 - n.y * n.y, 1.0 - n.z * n.z} * drag;
  }
}

/// The shares of least norm for an acceleration along z and an angular acceleration.
void set_rows(const std::string& robot, Guide& guide) {
  const Model& model = guide.model;
  Eigen::MatrixXd effect(4, model.rotors);
  for (int i = 0; i < model.rotors; ++i) {
    const Rotor& rotor = model.rotor[i];
    effect.col(i) << rotor.acceleration.z, rotor.angular_acceleration.x,
        rotor.angular_acceleration.y, rotor.angular_acceleration.z;
  }
  const Eigen::Vector4d size = effect.rowwise().norm().cwiseMax(1e-12);
  const Eigen::MatrixXd scaled = size.cwiseInverse().asDiagonal() * effect;
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition(scaled);
  if (decomposition.rank() < 4) {
    throw std::runtime_error("the rotors of robot `" + robot +
                             "` cannot give thrust along z and torque about each axis "
                             "independently, which nmpc needs: check position, axis, direction and "
                             "moment_constant in its rotors file, or use controller `srt`");
  }
  const Eigen::MatrixXd inverse = decomposition.pseudoInverse() * size.cwiseInverse().asDiagonal();
  for (int i = 0; i < model.rotors; ++i) {
    guide.rows[i] = {inverse(i, 0), {inverse(i, 1), inverse(i, 2), inverse(i, 3)}};
  }
}

}  // namespace

void set_vehicle(const Setup& setup, int robot, Guide& guide) {
  Model& model = guide.model;
  const double mass = control::total_mass(setup, robot);
  const SymMat3<double> inertia =
      control::inertia_of(setup.bodies()[control::base_of(setup, robot)]);
  model.inertia = to_mat3(inertia);
  model.inverse_inertia = to_mat3(inverse(inertia));
  model.gravity = control::vec3(setup.gravity());
  set_rotors(setup, robot, mass, model);
  set_drag(setup, robot, mass, model);
  set_rows(control::robot_name(setup, robot), guide);
}

}  // namespace skybody::nmpc
