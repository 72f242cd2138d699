#include "controllers/nmpc/solver.h"

namespace skybody::nmpc {
namespace {

constexpr double kLeastUprightShare = 0.01;

/// A vector limited to length `most`.
Vec3<double> shortened(const Vec3<double>& v, double most) {
  const double length = norm(v);
  return length > most ? v * (most / length) : v;
}

/// Rotation vector of a rotation, up to pi [rad].
Vec3<double> rotation_vector(const Quat<double>& q) {
  const double sign = q.w < 0.0 ? -1.0 : 1.0;
  const Vec3<double> axis{q.x * sign, q.y * sign, q.z * sign};
  const double sine = norm(axis);
  if (sine < 1e-9) return axis * 2.0;
  return axis * (2.0 * atan2(sine, q.w * sign) / sine);
}

/// Log(Exp(a) Exp(d)) = a + J_r(a)^-1 d to first order, with |a| <= pi (Chirikjian, section 10.3).
Mat3<double> inverse_right_jacobian(const Vec3<double>& a) {
  const double squared = squared_norm(a), angle = sqrt(squared);
  double second = 1.0 / 12.0 + squared / 720.0;
  if (angle > 1e-2) {
    const SinCos<double> half = sincos(0.5 * angle);
    second = (1.0 - 0.5 * angle * half.cos / half.sin) / squared;
  }
  const Mat3<double> k = skew(a);
  return Mat3<double>::identity() + k * 0.5 + (k * k) * second;
}

void put(double* out, const Vec3<double>& v) {
  out[0] = v.x;
  out[1] = v.y;
  out[2] = v.z;
}

/// Factor on the weights of position and velocity while the thrust points away from its desired
/// direction. Upside down, zero thrust minimises these errors to first order, and without thrust
/// the vehicle would never turn over.
double upright_share(const Motion& now, const Target& target) {
  const double cosine = dot(body_z(now.rotation), body_z(target.rotation));
  return max(kLeastUprightShare, square(0.5 + 0.5 * cosine));
}

/// Cost of the node after a step, about `motion`. @param factor  on all weights of states
/// @param upright  further factor, on the weights of position and velocity
void set_cost(const NmpcProblem& guide, const Motion& motion, const Target& target, double factor,
              double upright, Stage& stage) {
  const Weights& w = guide.weights;
  stage.position = w.position * (factor * upright);
  stage.velocity = w.velocity * (factor * upright);
  stage.rates = w.rates * factor;
  const Vec3<double> turn = rotation_vector(conjugate(target.rotation) * motion.rotation);
  const Mat3<double> by_turn = inverse_right_jacobian(turn);
  const Vec3<double> q = w.attitude * factor;
  Mat3<double> weighted = by_turn;
  for (int i = 0; i < 3; ++i) {
    weighted(0, i) *= q.x;
    weighted(1, i) *= q.y;
    weighted(2, i) *= q.z;
  }
  stage.attitude = transpose(by_turn) * weighted;
  put(stage.gradient, multiply_elements(stage.position, motion.position - target.position));
  put(stage.gradient + 3, multiply_elements(stage.velocity, motion.velocity - target.velocity));
  put(stage.gradient + 6, transpose_times(by_turn, multiply_elements(q, turn)));
  put(stage.gradient + 9, multiply_elements(stage.rates, motion.rates - target.rates));
}

/// The motion under the inputs, and the program's terms about it.
void linearise(const NmpcProblem& guide, const Motion& now, const Disturbance& disturbance,
               const Target* targets, const double* inputs, Stage* stages) {
  Motion motion = now;
  const double upright = upright_share(now, targets[0]);
  for (int k = 0; k < guide.nodes; ++k) {
    const double* const command = inputs + k * guide.model.rotors;
    advance(guide.model, guide.node, command, disturbance, motion, &stages[k].step);
    const bool is_last = k == guide.nodes - 1;
    set_cost(guide, motion, targets[k + 1], is_last ? guide.weights.terminal : 1.0, upright,
             stages[k]);
    for (int r = 0; r < guide.model.rotors; ++r) {
      stages[k].input_gradient[r] = guide.weights.input * (command[r] - targets[k].share[r]);
    }
  }
}

/// Moves all targets so that the first is within the allowed distance of the vehicle: the
/// linearisation is not valid far away.
void bring_near(const NmpcProblem& guide, const Vec3<double>& position, Target* targets) {
  const Vec3<double> ahead = targets[0].position - position;
  const Vec3<double> back = shortened(ahead, guide.most_position_error) - ahead;
  for (int k = 0; k <= guide.nodes; ++k) targets[k].position += back;
}

/// Inputs on a bound start in the active set.
QpResult solve_program(const NmpcProblem& guide, Condensed& program, const double* inputs,
                       double* change) {
  double low[kMostInputs], high[kMostInputs];
  QpBound start[kMostInputs];
  const int n = guide.nodes * guide.model.rotors;
  for (int i = 0; i < n; ++i) {
    low[i] = guide.least_share - inputs[i];
    high[i] = 1.0 - inputs[i];
    start[i] = low[i] >= 0.0 ? QpBound::kLower : high[i] <= 0.0 ? QpBound::kUpper : QpBound::kNone;
  }
  return solve({n, program.hessian, program.gradient, low, high, start, guide.most_iterations},
               change);
}

}  // namespace

Observed observe(const NmpcProblem& guide, const Motion& before, const double* command,
                 const Motion& now) {
  Motion predicted = before;
  advance(guide.model, guide.period, command, {}, predicted, nullptr);
  const double per_time = 1.0 / guide.period.h;
  return {(now.velocity - predicted.velocity) * per_time, (now.rates - predicted.rates) * per_time};
}

Vec3<double> observe_force(const Model& model, const Motion& now,
                           const Vec3<double>& specific_force) {
  const Vec3<double> air = rotate_inverse(now.rotation, now.velocity);
  Vec3<double> rest = specific_force + multiply_elements(model.drag, air);
  for (int r = 0; r < model.rotors; ++r) rest -= model.rotor[r].acceleration * now.share[r];
  return rotate(now.rotation, rest);
}

void follow(const NmpcProblem& guide, const Observed& observed, Disturbance& estimate) {
  const auto pass = [&](Vec3<double>& value, const Vec3<double>& sample, double most) {
    const Vec3<double> next = value + (sample - value) * guide.disturbance_gain;
    if (is_finite(next)) value = shortened(next, most);
  };
  pass(estimate.acceleration, observed.acceleration, guide.most_acceleration);
  pass(estimate.angular_acceleration, observed.angular_acceleration, guide.most_angular);
}

void shift(const NmpcProblem& guide, double* inputs) {
  const int rotors = guide.model.rotors;
  const double part = guide.period.h / guide.node.h;
  for (int i = 0; i < (guide.nodes - 1) * rotors; ++i) {
    inputs[i] += part * (inputs[i + rotors] - inputs[i]);
  }
}

QpResult improve(const NmpcProblem& guide, const Motion& now, const Disturbance& disturbance,
                 Target* targets, double* inputs) {
  Stage stages[kMostNodes];
  Condensed program;
  double change[kMostInputs];
  bring_near(guide, now.position, targets);
  linearise(guide, now, disturbance, targets, inputs, stages);
  condense({guide.nodes, guide.model.rotors, guide.node.h, guide.weights.input}, stages, program);
  const QpResult result = solve_program(guide, program, inputs, change);
  if (!result.is_solved) return result;
  const int n = guide.nodes * guide.model.rotors;
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += change[i];
  if (!is_finite(sum)) return {false, result.iterations};
  for (int i = 0; i < n; ++i) inputs[i] = clamp(inputs[i] + change[i], guide.least_share, 1.0);
  return result;
}

}  // namespace skybody::nmpc
