// The guide's arithmetic: an estimate of what disturbs, and one real-time iteration (M. Diehl, H.
// G. Bock, J. P. Schloder, "A real-time iteration scheme for nonlinear optimization in optimal
// feedback control", SIAM J. Control Optim. 43(5), 2005): the motion that the last inputs lead to
// from where the vehicle is, linearised; the Gauss-Newton program about it, condensed; a full step.
//
// Compiled once, for the baseline instruction set, so that bits are the same on every processor.
// Nothing is allocated; a call takes about 1 MB of stack.
#pragma once

#include "controllers/nmpc/condense.h"
#include "controllers/nmpc/target.h"

namespace skybody::nmpc {

/// Weights of squared errors at a node; of inputs, of shares of full thrust.
struct Weights {
  Vec3<double> position{};  ///< W axes [1/m^2]
  Vec3<double> velocity{};  ///< W axes [s^2/m^2]
  Vec3<double> attitude{};  ///< B axes [1/rad^2]
  Vec3<double> rates{};     ///< B axes [s^2/rad^2]
  double input = 0.0;
  double terminal = 1.0;  ///< factor on those of the last node
};

/// All that is constant over a flight.
struct NmpcProblem {
  Model model;
  ShareRow rows[kMostRotors];
  Weights weights;
  int nodes = 0;
  StepLength node;    ///< from node to node
  StepLength period;  ///< from one iteration to the next, at most a node's
  double least_share = 0.0;
  double most_position_error = 0.0;  ///< [m]; beyond it the reference is brought nearer
  int most_iterations = 0;           ///< of the program
  double disturbance_gain = 0.0;     ///< of the estimate's low pass, a period
  double most_acceleration = 0.0;    ///< of the estimate [m/s^2]
  double most_angular = 0.0;         ///< likewise [rad/s^2]
};

/// What acted beside weight, rotors and drag, over the last period or now.
struct Observed {
  Vec3<double> acceleration;          ///< W [m/s^2]
  Vec3<double> angular_acceleration;  ///< B [rad/s^2]
};

/// By how the vehicle moved over the last period and how it should have moved without disturbance.
/// @param command  shares, held over that period
Observed observe(const NmpcProblem& guide, const Motion& before, const double* command,
                 const Motion& now);

/// The acceleration beside weight, rotors and drag, by an accelerometer at the base's frame [W].
/// @param specific_force  B [m/s^2]
Vec3<double> observe_force(const Model& model, const Motion& now,
                           const Vec3<double>& specific_force);

/// One step of the estimate's low pass. What is not finite is left out.
void follow(const NmpcProblem& guide, const Observed& observed, Disturbance& estimate);

/// The inputs one period later: between nodes along straight lines, the last one kept.
void shift(const NmpcProblem& guide, double* inputs);

/// One iteration. Where the program is not solved, `inputs` stay as they are.
/// @param targets  of nodes 0 to `nodes`; they are brought near
/// @param inputs   shares, rotor by rotor, node after node
QpResult improve(const NmpcProblem& guide, const Motion& now, const Disturbance& disturbance,
                 Target* targets, double* inputs);

}  // namespace skybody::nmpc
