#include "controllers/nmpc/vehicle.h"

#include <string>
#include <vector>

#include "controllers/common/allocation.h"
#include "controllers/common/pseudo_inverse.h"

namespace skybody::nmpc {
namespace {

/// Acceleration and angular acceleration at full thrust of each rotor, about the base's centre of
/// mass.
void set_rotors(const Setup& setup, int robot, double mass, Model& model) {
  const View<RotorInfo> rotors = control::working_rotors(setup, robot, "nmpc");
  const BodyInfo& base = setup.bodies()[control::base_of(setup, robot)];
  if (rotors.size() > kMostRotors) {
    refuse("robot `", control::robot_name(setup, robot), "` has ", rotors.size(),
           " rotors; nmpc takes up to ", kMostRotors, ": use another controller");
  }
  control::require_on_base(setup, robot, rotors,
                           "; nmpc needs rotors fixed to the base: use controller `srt`");
  model.rotors = rotors.size();
  for (int i = 0; i < rotors.size(); ++i) {
    const RotorInfo& rotor = rotors[i];
    const double full = control::full_thrust(rotor);
    model.rotor[i] = {control::vec3(rotor.axis_in_base) * (full / mass),
                      model.inverse_inertia * (control::effect_of(rotor, base).torque * full),
                      rotor.constants[SKYBODY_ROTOR_TAU_UP],
                      rotor.constants[SKYBODY_ROTOR_TAU_DOWN]};
  }
}

/// Drag of the rotors, k_d w (v - (v . n) n) each, at hover speeds: its diagonal in base axes, per
/// mass.
void set_drag(const Setup& setup, int robot, double mass, Model& model) {
  double lift = 0.0;
  for (int i = 0; i < model.rotors; ++i) lift += max(0.0, model.rotor[i].acceleration.z);
  const double share = clamp(norm(model.gravity) / lift, 0.0, 1.0);
  for (const RotorInfo& rotor : setup.rotors_of(robot)) {
    const double speed = rotor.constants[SKYBODY_ROTOR_MAX_SPEED] * sqrt(share);
    const double drag = rotor.constants[SKYBODY_ROTOR_DRAG_CONSTANT] * speed / mass;
    const Vec3<double> n = control::vec3(rotor.axis_in_base);
    model.drag += Vec3<double>{1.0 - n.x * n.x, 1.0 - n.y * n.y, 1.0 - n.z * n.z} * drag;
  }
}

/// Rotor shares of least norm for an acceleration along z and an angular acceleration.
void set_rows(const std::string& robot, NmpcProblem& guide) {
  std::vector<double> effects;
  for (int i = 0; i < guide.model.rotors; ++i) {
    const Rotor& rotor = guide.model.rotor[i];
    const Vec3<double>& turn = rotor.angular_acceleration;
    effects.insert(effects.end(), {rotor.acceleration.z, turn.x, turn.y, turn.z});
  }
  const std::vector<double> inverse = control::PseudoInverse::of(effects, robot, "nmpc");
  for (int i = 0; i < guide.model.rotors; ++i) {
    const double* const row = &inverse[static_cast<std::size_t>(4 * i)];
    guide.rows[i] = {row[0], {row[1], row[2], row[3]}};
  }
}

}  // namespace

void set_vehicle(const Setup& setup, int robot, NmpcProblem& guide) {
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
