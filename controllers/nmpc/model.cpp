#include "controllers/nmpc/model.h"

namespace skybody::nmpc {
namespace {

/// Quantities of a step, shared by motion and derivatives.
struct Within {
  const Lag* lag[kMostRotors];
  Vec3<double> mean_rates;  ///< w_m
  Quat<double> half_turn;   ///< Exp(h/4 (w + w_m))
  Quat<double> full_turn;   ///< Exp(h w_m)
  Quat<double> middle;      ///< R_m
  Vec3<double> fall;        ///< R_m^T (v + h/2 (g + d)) [m/s]
  Vec3<double> push;        ///< sum a_i mean(f_i) - D R_m^T v_m [m/s^2]
  Vec3<double> spin;        ///< sum b_i mean(f_i) - J^-1 (w_m x J w_m) + e [rad/s^2]
};

Vec3<double> gyro(const Model& model, const Vec3<double>& w) {
  return model.inverse_inertia * cross(w, model.inertia * w);
}

Within within(const Model& model, const StepLength& step, const double* command,
              const Disturbance& disturbance, const Motion& from) {
  Within s;
  Vec3<double> push{0.0, 0.0, 0.0}, spin{0.0, 0.0, 0.0}, second{0.0, 0.0, 0.0};
  for (int i = 0; i < model.rotors; ++i) {
    s.lag[i] = command[i] > from.share[i] ? &step.up[i] : &step.down[i];
    const double gap = from.share[i] - command[i];
    const double mean = command[i] + gap * s.lag[i]->mean;
    push += model.rotor[i].acceleration * mean;
    spin += model.rotor[i].angular_acceleration * mean;
    second += model.rotor[i].angular_acceleration * (command[i] + gap * s.lag[i]->second);
  }
  const Vec3<double>& w = from.rates;
  const Vec3<double>& e = disturbance.angular_acceleration;
  s.mean_rates = w + (second - gyro(model, w) + e) * (0.5 * step.h);
  s.half_turn = from_rotation_vector((w + s.mean_rates) * (0.25 * step.h));
  s.full_turn = from_rotation_vector(s.mean_rates * step.h);
  s.middle = from.rotation * s.half_turn;
  const Vec3<double> weight = model.gravity + disturbance.acceleration;
  s.fall = rotate_inverse(s.middle, from.velocity + weight * (0.5 * step.h));
  s.push = push - multiply_elements(step.drag, s.fall + push * (0.5 * step.h));
  s.spin = spin - gyro(model, s.mean_rates) + e;
  return s;
}

Mat3<double> diagonal(const Vec3<double>& d) {
  return {{d.x, 0.0, 0.0, 0.0, d.y, 0.0, 0.0, 0.0, d.z}};
}

void set_column(double (&rows)[3][kMostRotors], int i, const Vec3<double>& v) {
  rows[0][i] = v.x;
  rows[1][i] = v.y;
  rows[2][i] = v.z;
}

void differentiate(const Model& model, const StepLength& step, const Motion& from, const Within& s,
                   StepJacobian& j) {
  const double h = step.h;
  const Mat3<double> one = Mat3<double>::identity(), r = to_mat3(s.middle);
  // Derivatives of the mean rates and of the rates in the middle, by the rates.
  const Mat3<double> mean_by_w =
      one - (model.inverse_inertia * gyro_jacobian(model, from.rates)) * (0.5 * h);
  const Mat3<double> gyro_by_mean =
      (model.inverse_inertia * gyro_jacobian(model, s.mean_rates)) * h;
  const Mat3<double> turn_by_mean = right_jacobian(s.mean_rates * h) * h;
  const Mat3<double> middle_by_rates =
      right_jacobian((from.rates + s.mean_rates) * (0.25 * h)) * (0.25 * h);
  const Mat3<double> middle_by_turn = transpose(to_mat3(s.half_turn));
  const Mat3<double> drag = diagonal(step.drag);
  // Derivative of R_m push by a rotation of R_m; push includes drag, which rotates with R_m.
  const Mat3<double> v_by_middle = (r * (skew(s.push) + drag * skew(s.fall))) * -h;
  j.v_v = one - (r * drag * transpose(r)) * h;
  j.v_t = v_by_middle * middle_by_turn;
  j.v_w = v_by_middle * (middle_by_rates * (one + mean_by_w));
  j.t_t = transpose(to_mat3(s.full_turn));
  j.t_w = turn_by_mean * mean_by_w;
  j.w_w = one - gyro_by_mean * mean_by_w;
  const Mat3<double> v_by_mean = v_by_middle * middle_by_rates;
  for (int i = 0; i < model.rotors; ++i) {
    const Rotor& rotor = model.rotor[i];
    const Vec3<double> mean_by_second = rotor.angular_acceleration * (0.5 * h);
    const Vec3<double> dragged = multiply_elements(step.drag, rotor.acceleration) * (0.5 * h);
    const Vec3<double> v_by_mean_share = (r * (rotor.acceleration - dragged)) * h;
    const Vec3<double> v_by_second = v_by_mean * mean_by_second;
    const Vec3<double> t_by_second = turn_by_mean * mean_by_second;
    const Vec3<double> w_by_mean_share = rotor.angular_acceleration * h;
    const Vec3<double> w_by_second = gyro_by_mean * mean_by_second * -1.0;
    const double mean = s.lag[i]->mean, second = s.lag[i]->second;
    set_column(j.v_f, i, v_by_mean_share * mean + v_by_second * second);
    set_column(j.t_f, i, t_by_second * second);
    set_column(j.w_f, i, w_by_mean_share * mean + w_by_second * second);
    set_column(j.v_u, i, v_by_mean_share * (1.0 - mean) + v_by_second * (1.0 - second));
    set_column(j.t_u, i, t_by_second * (1.0 - second));
    set_column(j.w_u, i, w_by_mean_share * (1.0 - mean) + w_by_second * (1.0 - second));
    j.f_f[i] = s.lag[i]->decay;
  }
}

}  // namespace

void advance(const Model& model, const StepLength& step, const double* command,
             const Disturbance& disturbance, Motion& motion, StepJacobian* jacobian) {
  const Within s = within(model, step, command, disturbance, motion);
  if (jacobian != nullptr) differentiate(model, step, motion, s, *jacobian);
  const double h = step.h;
  const Vec3<double> before = motion.velocity;
  motion.velocity += (model.gravity + rotate(s.middle, s.push) + disturbance.acceleration) * h;
  motion.position += (before + motion.velocity) * (0.5 * h);
  motion.rotation = normalized(motion.rotation * s.full_turn);
  motion.rates += s.spin * h;
  for (int i = 0; i < model.rotors; ++i) {
    motion.share[i] = command[i] + (motion.share[i] - command[i]) * s.lag[i]->decay;
  }
}

}  // namespace skybody::nmpc
