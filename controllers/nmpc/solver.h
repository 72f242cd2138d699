// Solver of the controller: a disturbance estimate and one real-time iteration (M. Diehl, H. G.
// Bock, J. P. Schloder, "A real-time iteration scheme for nonlinear optimization in optimal
// feedback control", SIAM J. Control Optim. 43(5), 2005). An iteration
//   1. predicts the motion from the present state under the last inputs and linearises it,
//   2. condenses the Gauss-Newton program about it,
//   3. takes a full step.
//
// Compiled once for the baseline instruction set, so that results are bitwise equal on every
// processor. Nothing is allocated; a call takes about 1 MB of stack.
#pragma once

#include "controllers/nmpc/condense.h"
#include "controllers/nmpc/target.h"

namespace skybody::nmpc {

/// Weights of squared errors at a node; for inputs, of shares of full thrust.
struct Weights {
  Vec3<double> position{};  ///< W axes [1/m^2]
  Vec3<double> velocity{};  ///< W axes [s^2/m^2]
  Vec3<double> attitude{};  ///< B axes [1/rad^2]
  Vec3<double> rates{};     ///< B axes [s^2/rad^2]
  double input = 0.0;
  double terminal = 1.0;  ///< factor on the weights of the last node
};

/// Constants of a flight.
struct NmpcProblem {
  Model model;
  ShareRow rows[kMostRotors];
  Weights weights;
  int nodes = 0;
  StepLength node;    ///< from node to node
  StepLength period;  ///< from one iteration to the next, at most a node step
  double least_share = 0.0;
  double most_position_error = 0.0;  ///< [m]; a more distant reference is moved nearer
  int most_iterations = 0;           ///< limit of the program's iterations
  double disturbance_gain = 0.0;     ///< of the estimate's low pass, per period
  double most_acceleration = 0.0;    ///< limit of the estimate [m/s^2]
  double most_angular = 0.0;         ///< limit of the estimate [rad/s^2]
};

/// Disturbance: acceleration not explained by weight, rotors and drag, over the last period or now.
struct Observed {
  Vec3<double> acceleration;          ///< W [m/s^2]
  Vec3<double> angular_acceleration;  ///< B [rad/s^2]
};

/// Disturbance from the vehicle's motion over the last period, compared with the motion predicted
/// without disturbance.
/// @param command  shares, constant over that period
Observed observe(const NmpcProblem& guide, const Motion& before, const double* command,
                 const Motion& now);

/// The acceleration not explained by weight, rotors and drag, from an accelerometer at the base's
/// frame [W].
/// @param specific_force  B [m/s^2]
Vec3<double> observe_force(const Model& model, const Motion& now,
                           const Vec3<double>& specific_force);

/// One step of the estimate's low pass. Non-finite values are ignored.
void follow(const NmpcProblem& guide, const Observed& observed, Disturbance& estimate);

/// Shifts the inputs by one period: linear interpolation between nodes; the last one is kept.
void shift(const NmpcProblem& guide, double* inputs);

/// One iteration. If the program is not solved, `inputs` are unchanged.
/// @param targets  of nodes 0 to `nodes`; moved nearer if they are too far away
/// @param inputs   shares, rotor by rotor, node after node
QpResult improve(const NmpcProblem& guide, const Motion& now, const Disturbance& disturbance,
                 Target* targets, double* inputs);

}  // namespace skybody::nmpc
