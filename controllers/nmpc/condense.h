// Condensing: eliminates the states of a linearised horizon by the dynamics. The resulting program
// has horizon x rotors variables, the inputs.
//
// With e_k the tangents of the state at node k and A_k, B_k a step's derivatives,
//   e_0 = 0,  e_(k+1) = A_k e_k + B_k d_k,
//   minimise  sum_k (1/2 e_k' Q_k e_k + q_k' e_k) + sum_k (r/2 |d_k|^2 + g_k' d_k)
// becomes 1/2 d' H d + h' d. The Hessian takes O(horizon^2) products of a stage's matrices (G.
// Frison, Algorithms and methods for high-performance model predictive control, 2015, section 6.2):
// the columns of e_k by d forwards, the adjoint of each backwards. All sums run over rows in
// memory, one element at a time, so the order of summation does not depend on the vector width.
#pragma once

#include "controllers/nmpc/model.h"
#include "controllers/nmpc/qp.h"

namespace skybody::nmpc {

inline constexpr int kMostNodes = 40;  ///< largest number of nodes of a horizon

/// One step of the horizon and the cost of the node at its end, about a trajectory.
struct Stage {
  StepJacobian step;
  Vec3<double> position, velocity, rates;  ///< diagonals of Q
  Mat3<double> attitude;                   ///< block of the rotations
  double gradient[12];                     ///< q: position, velocity, rotation, rates
  double input_gradient[kMostRotors];      ///< g of the step's inputs
};

struct Horizon {
  int nodes = 0;
  int rotors = 0;
  double node_step = 0.0;     ///< h [s]
  double input_weight = 0.0;  ///< r
};

/// The program without its bounds.
struct Condensed {
  double hessian[kMostInputs * kMostInputs];  ///< n x n, row-major, n = nodes x rotors
  double gradient[kMostInputs];
};

void condense(const Horizon& horizon, const Stage* stages, Condensed& out);

}  // namespace skybody::nmpc
