// Linear-quadratic regulators: the optimal gain for x' = A x + B u and the cost's weights.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace skybody::control {

/// Solves A'X + X A - X B R^-1 B' X + Q = 0 for the X that makes A - B R^-1 B' X stable, by
/// doubling. Deterministic: products, sums and quotients only.
///
/// Source: E. K.-W. Chu, H.-Y. Fan and W.-W. Lin, A structure-preserving doubling algorithm for
/// continuous-time algebraic Riccati equations, Linear Algebra and its Applications 396, 2005,
/// algorithm 3.1.
/// @throws std::runtime_error if it does not converge, because no gain makes x stable
Eigen::MatrixXd solve_riccati(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                              const Eigen::MatrixXd& q, const Eigen::MatrixXd& r);

/// K of u = -K x that minimises the integral of x'Q x + u'R u. @throws as solve_riccati()
Eigen::MatrixXd regulator_gain(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                               const Eigen::MatrixXd& q, const Eigen::MatrixXd& r);

/// The same for a chain of integrators with one input at its end: x_i' = step_i x_(i+1).
/// @param steps    factors of all integrators but the last, whose derivative is the input
/// @param weights  of the states, one more than steps
Eigen::VectorXd chain_gain(const std::vector<double>& steps, const std::vector<double>& weights,
                           double input_weight);

}  // namespace skybody::control
