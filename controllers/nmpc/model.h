// Prediction model of the vehicle: one rigid body with rotors fixed to it, each thrust with a
// first-order lag; and its motion over one step with all derivatives.
//
// Symbols: p, v position and velocity (W), R attitude (W from B), w rates (B), f_i rotor i's thrust
// as a share of its full thrust, u_i the commanded share, a_i and b_i the acceleration and angular
// acceleration at full thrust (B), J inertia, D drag per mass (B axes), d and e the linear and
// angular disturbance:
//   f_i' = (u_i - f_i) / tau_i           tau_i the rotor's tau_up if u_i > f_i, else tau_down
//   w'   = sum_i b_i f_i - J^-1 (w x J w) + e
//   R'   = R skew(w)
//   v'   = g + R (sum_i a_i f_i - D R^T v) + d
//   p'   = v
//
// A step of length h is the explicit midpoint rule on SO(3) x R^n (E. Hairer, C. Lubich, G. Wanner,
// Geometric Numerical Integration, 2006, section IV.8). In place of the midpoint's shares it uses
// closed forms of the lag: the mean over the step, mean(f) = u + (f - u) m, for the forces, and the
// second mean, 2/h^2 int int f = u + (f - u) n, for the mean rates:
//   m = (1 - e^(-h/tau)) tau/h,   n = (1 - m) 2 tau/h
//   w_m = w + h/2 (sum b_i secondmean(f_i) - J^-1 (w x J w) + e)
//   R_m = R Exp(h/4 (w + w_m)),   R(h) = R Exp(h w_m)
//   w(h) = w + h (sum b_i mean(f_i) - J^-1 (w_m x J w_m) + e)
//   v_m = v + h/2 (g + R_m (sum a_i mean(f_i) - D R_m^T v_m) + d)     implicit, in closed form
//   v(h) = v + h (g + R_m (sum a_i mean(f_i) - D R_m^T v_m) + d)
//   p(h) = p + h/2 (v + v(h))
//
// Attitudes change by R Exp(t), t a rotation in B axes [rad], so that a state has 12 + N tangents.
#pragma once

#include "core/base/math/math.h"
#include "core/base/math/quat.h"

namespace skybody::nmpc {

inline constexpr int kMostRotors = 16;

/// The predicted state. W: world, B: base.
struct Motion {
  Vec3<double> position;      ///< of the base, W [m]
  Vec3<double> velocity;      ///< W [m/s]
  Quat<double> rotation;      ///< W from B
  Vec3<double> rates;         ///< B [rad/s]
  double share[kMostRotors];  ///< of each rotor's full thrust, 0 to 1
};

/// Disturbances: accelerations not explained by weight, rotors and drag. Constant over the horizon.
struct Disturbance {
  Vec3<double> acceleration{0.0, 0.0, 0.0};          ///< W [m/s^2]
  Vec3<double> angular_acceleration{0.0, 0.0, 0.0};  ///< B [rad/s^2]
};

/// One rotor's effect on the vehicle at full thrust, and its lag.
struct Rotor {
  Vec3<double> acceleration;          ///< the vehicle's acceleration at full thrust, B [m/s^2]
  Vec3<double> angular_acceleration;  ///< the vehicle's angular acceleration at full thrust, B
                                      ///< [rad/s^2]
  double tau_up, tau_down;            ///< [s], may be 0
};

/// The vehicle's nominal constants.
struct Model {
  int rotors = 0;
  Rotor rotor[kMostRotors];
  Vec3<double> gravity{0.0, 0.0, 0.0};  ///< W [m/s^2]
  Vec3<double> drag{0.0, 0.0, 0.0};     ///< per mass, along B axes [1/s]
  Mat3<double> inertia{};               ///< B [kg m^2]
  Mat3<double> inverse_inertia{};
};

/// The factors of a rotor's lag over a step of one length, for one time constant tau.
struct Lag {
  double decay;   ///< e^(-h/tau)
  double mean;    ///< m of the mean share over the step, see above
  double second;  ///< n of the second mean, see above
};

/// A step's length and the constants derived from it.
struct StepLength {
  double h = 0.0;                    ///< [s]
  Vec3<double> drag{0.0, 0.0, 0.0};  ///< D / (1 + h/2 D), factor on the part of v_m without drag
  Lag up[kMostRotors], down[kMostRotors];
};

inline Lag lag_over(double h, double tau) {
  if (!(tau > 1e-9)) return {0.0, 0.0, 0.0};
  const double ratio = tau / h, mean = -expm1(-h / tau) * ratio;
  return {exp(-h / tau), mean, 2.0 * ratio * (1.0 - mean)};
}

inline StepLength step_length(const Model& model, double h) {
  StepLength step;
  step.h = h;
  const Vec3<double>& d = model.drag;
  step.drag = {d.x / (1.0 + 0.5 * h * d.x), d.y / (1.0 + 0.5 * h * d.y),
               d.z / (1.0 + 0.5 * h * d.z)};
  for (int i = 0; i < model.rotors; ++i) {
    step.up[i] = lag_over(h, model.rotor[i].tau_up);
    step.down[i] = lag_over(h, model.rotor[i].tau_down);
  }
  return step;
}

/// Derivatives of the motion after a step by the motion before it: of the velocity's change `v_`,
/// of the rotation `t_`, of the rates `w_`, by v, t, w, each rotor's share f and its command u.
/// Derivatives not listed are 0, or the identity for the position by itself; the position's follow
/// from p(h) = p + h/2 (v + v(h)).
struct StepJacobian {
  Mat3<double> v_v, v_t, v_w, t_t, t_w, w_w;
  double v_f[3][kMostRotors], t_f[3][kMostRotors], w_f[3][kMostRotors];
  double v_u[3][kMostRotors], t_u[3][kMostRotors], w_u[3][kMostRotors];
  double f_f[kMostRotors];  ///< f_u = 1 - f_f
};

/// Right Jacobian of SO(3): Exp(a + d) = Exp(a) Exp(J_r(a) d) to first order (G. Chirikjian,
/// Stochastic Models, Information Theory, and Lie Groups 2, 2012, section 10.3).
inline Mat3<double> right_jacobian(const Vec3<double>& a) {
  const double squared = squared_norm(a), angle = sqrt(squared);
  double first = 0.5 - squared / 24.0, second = 1.0 / 6.0 - squared / 120.0;  // series near 0
  if (angle > 1e-3) {
    const SinCos<double> s = sincos(angle);
    first = (1.0 - s.cos) / squared;
    second = (angle - s.sin) / (squared * angle);
  }
  const Mat3<double> k = skew(a);
  return Mat3<double>::identity() - k * first + (k * k) * second;
}

/// d(w x J w) = gyro_jacobian(w) dw.
inline Mat3<double> gyro_jacobian(const Model& model, const Vec3<double>& w) {
  return skew(w) * model.inertia - skew(model.inertia * w);
}

/// Advances `motion` by one step. @param jacobian  filled unless null
void advance(const Model& model, const StepLength& step, const double* command,
             const Disturbance& disturbance, Motion& motion, StepJacobian* jacobian);

}  // namespace skybody::nmpc
