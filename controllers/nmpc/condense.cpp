#include "controllers/nmpc/condense.h"

namespace skybody::nmpc {
namespace {

constexpr int kTangents = 12;  ///< position 0, velocity 3, rotation 6, rates 9; then the rotors'
constexpr int kMostRows = kTangents + kMostRotors;

/// Contiguous rows of numbers.
struct Rows {
  double* data;
  int stride;
  double* operator[](int i) const { return data + i * stride; }
};

/// out += a x + b y + c z, element by element.
void add(double* __restrict out, double a, const double* __restrict x, double b,
         const double* __restrict y, double c, const double* __restrict z, int n) {
  for (int i = 0; i < n; ++i) out[i] += (a * x[i] + b * y[i]) + c * z[i];
}
void add(double* __restrict out, double a, const double* __restrict x, int n) {
  for (int i = 0; i < n; ++i) out[i] += a * x[i];
}

void set_zero(double* out, int n) {
  for (int i = 0; i < n; ++i) out[i] = 0.0;
}

/// out_i += sum_k m(i, k) x_k, three rows each.
void add_product(const Mat3<double>& m, const Rows& x, int first, const Rows& out, int to, int n) {
  for (int i = 0; i < 3; ++i) {
    add(out[to + i], m(i, 0), x[first], m(i, 1), x[first + 1], m(i, 2), x[first + 2], n);
  }
}
/// The same with the transpose of m.
void add_transposed(const Mat3<double>& m, const Rows& x, int first, const Rows& out, int to,
                    int n) {
  for (int i = 0; i < 3; ++i) {
    add(out[to + i], m(0, i), x[first], m(1, i), x[first + 1], m(2, i), x[first + 2], n);
  }
}

/// Adds the effect of rotor shares. The share of rotor r depends on inputs of the same rotor only;
/// `shares` has one number per input so far.
void add_shares(const double (&by_share)[3][kMostRotors], const double* shares, int rotors,
                const Rows& out, int to, int columns) {
  for (int i = 0; i < 3; ++i) {
    double* const row = out[to + i];
    for (int c = 0; c < columns; c += rotors) {
      for (int r = 0; r < rotors; ++r) row[c + r] += by_share[i][r] * shares[c + r];
    }
  }
}

/// Tangents after a step by all inputs, from the tangents before it.
/// @param columns  number of inputs before this step
void propagate(const Stage& stage, const Horizon& horizon, int columns, const Rows& from,
               double* shares, const Rows& to) {
  const StepJacobian& j = stage.step;
  const int rotors = horizon.rotors;
  const double half = 0.5 * horizon.node_step;
  set_zero(to.data, kTangents * to.stride);
  add_product(j.v_v, from, 3, to, 3, columns);
  add_product(j.v_t, from, 6, to, 3, columns);
  add_product(j.v_w, from, 9, to, 3, columns);
  add_shares(j.v_f, shares, rotors, to, 3, columns);
  add_product(j.t_t, from, 6, to, 6, columns);
  add_product(j.t_w, from, 9, to, 6, columns);
  add_shares(j.t_f, shares, rotors, to, 6, columns);
  add_product(j.w_w, from, 9, to, 9, columns);
  add_shares(j.w_f, shares, rotors, to, 9, columns);
  for (int r = 0; r < rotors; ++r) {
    for (int i = 0; i < 3; ++i) {
      to[3 + i][columns + r] = j.v_u[i][r];
      to[6 + i][columns + r] = j.t_u[i][r];
      to[9 + i][columns + r] = j.w_u[i][r];
    }
    shares[columns + r] = 1.0 - j.f_f[r];
    for (int c = r; c < columns; c += rotors) shares[c] *= j.f_f[r];
  }
  for (int i = 0; i < 3; ++i) {
    add(to[i], 1.0, from[i], columns);
    add(to[i], half, from[3 + i], columns);
    add(to[i], half, to[3 + i], columns + rotors);
  }
}

/// adjoint += Q tangents.
void add_cost(const Stage& stage, const Rows& tangents, const Rows& adjoint, int columns) {
  const double diagonal[kTangents] = {stage.position.x,
                                      stage.position.y,
                                      stage.position.z,
                                      stage.velocity.x,
                                      stage.velocity.y,
                                      stage.velocity.z,
                                      0.0,
                                      0.0,
                                      0.0,
                                      stage.rates.x,
                                      stage.rates.y,
                                      stage.rates.z};
  for (int i = 0; i < kTangents; ++i) add(adjoint[i], diagonal[i], tangents[i], columns);
  add_product(stage.attitude, tangents, 6, adjoint, 6, columns);
}

/// The position's adjoint acts on velocities as well, by p(h) = p + h/2 (v + v(h)).
void fold_position(double half, const Rows& adjoint, int columns) {
  for (int i = 0; i < 3; ++i) add(adjoint[3 + i], half, adjoint[i], columns);
}

/// out = B' adjoint, one row per rotor. @param adjoint  folded
void by_inputs(const StepJacobian& j, int rotors, const Rows& adjoint, const Rows& out,
               int columns) {
  for (int r = 0; r < rotors; ++r) {
    set_zero(out[r], columns);
    add(out[r], j.v_u[0][r], adjoint[3], j.v_u[1][r], adjoint[4], j.v_u[2][r], adjoint[5], columns);
    add(out[r], j.t_u[0][r], adjoint[6], j.t_u[1][r], adjoint[7], j.t_u[2][r], adjoint[8], columns);
    add(out[r], j.w_u[0][r], adjoint[9], j.w_u[1][r], adjoint[10], j.w_u[2][r], adjoint[11],
        columns);
    add(out[r], 1.0 - j.f_f[r], adjoint[kTangents + r], columns);
  }
}

/// out = A' adjoint. @param adjoint  folded
void pull_back(const StepJacobian& j, const Horizon& horizon, const Rows& adjoint, const Rows& out,
               int columns) {
  for (int i = 0; i < kTangents + horizon.rotors; ++i) set_zero(out[i], columns);
  for (int i = 0; i < 3; ++i) {
    add(out[i], 1.0, adjoint[i], columns);
    add(out[3 + i], 0.5 * horizon.node_step, adjoint[i], columns);
  }
  add_transposed(j.v_v, adjoint, 3, out, 3, columns);
  add_transposed(j.v_t, adjoint, 3, out, 6, columns);
  add_transposed(j.t_t, adjoint, 6, out, 6, columns);
  add_transposed(j.v_w, adjoint, 3, out, 9, columns);
  add_transposed(j.t_w, adjoint, 6, out, 9, columns);
  add_transposed(j.w_w, adjoint, 9, out, 9, columns);
  for (int r = 0; r < horizon.rotors; ++r) {
    double* const row = out[kTangents + r];
    add(row, j.v_f[0][r], adjoint[3], j.v_f[1][r], adjoint[4], j.v_f[2][r], adjoint[5], columns);
    add(row, j.t_f[0][r], adjoint[6], j.t_f[1][r], adjoint[7], j.t_f[2][r], adjoint[8], columns);
    add(row, j.w_f[0][r], adjoint[9], j.w_f[1][r], adjoint[10], j.w_f[2][r], adjoint[11], columns);
    add(row, j.f_f[r], adjoint[kTangents + r], columns);
  }
}

/// Offset of the tangents of node k, after those of nodes 1 to k - 1, 12 x inputs each.
int place_of(int node, int rotors) { return kTangents * rotors * node * (node - 1) / 2; }

/// Size for a horizon of kMostInputs inputs over kMostNodes nodes.
constexpr int kMostTangents = kTangents * kMostInputs * (kMostNodes + 1) / 2;

/// Lower triangle of the Hessian, one block row after another, from the last one.
void fill_hessian(const Horizon& horizon, const Stage* stages, double* tangents, double* hessian) {
  const int rotors = horizon.rotors, n = horizon.nodes * rotors;
  double memory[2][kMostRows * kMostInputs];
  Rows adjoint{memory[0], n}, next{memory[1], n};
  for (int i = 0; i < kTangents + rotors; ++i) set_zero(adjoint[i], n);
  for (int k = horizon.nodes - 1; k >= 0; --k) {
    const int columns = (k + 1) * rotors;
    add_cost(stages[k], {tangents + place_of(k + 1, rotors), columns}, adjoint, columns);
    fold_position(0.5 * horizon.node_step, adjoint, columns);
    by_inputs(stages[k].step, rotors, adjoint, {hessian + k * rotors * n, n}, columns);
    pull_back(stages[k].step, horizon, adjoint, next, k * rotors);
    const Rows spare = adjoint;
    adjoint = next;
    next = spare;
  }
}

void fill_gradient(const Horizon& horizon, const Stage* stages, double* gradient) {
  double memory[2][kMostRows] = {};
  Rows adjoint{memory[0], 1}, next{memory[1], 1};
  for (int k = horizon.nodes - 1; k >= 0; --k) {
    for (int i = 0; i < kTangents; ++i) *adjoint[i] += stages[k].gradient[i];
    fold_position(0.5 * horizon.node_step, adjoint, 1);
    double* const part = gradient + k * horizon.rotors;
    by_inputs(stages[k].step, horizon.rotors, adjoint, {part, 1}, 1);
    for (int r = 0; r < horizon.rotors; ++r) part[r] += stages[k].input_gradient[r];
    pull_back(stages[k].step, horizon, adjoint, next, 1);
    const Rows spare = adjoint;
    adjoint = next;
    next = spare;
  }
}

}  // namespace

void condense(const Horizon& horizon, const Stage* stages, Condensed& out) {
  const int rotors = horizon.rotors, n = horizon.nodes * rotors;
  double tangents[kMostTangents], shares[kMostInputs];
  for (int k = 0; k < horizon.nodes; ++k) {
    const int columns = k * rotors;
    propagate(stages[k], horizon, columns, {tangents + place_of(k, rotors), columns}, shares,
              {tangents + place_of(k + 1, rotors), columns + rotors});
  }
  fill_hessian(horizon, stages, tangents, out.hessian);
  for (int i = 0; i < n; ++i) {
    out.hessian[i * n + i] += horizon.input_weight;
    for (int j = 0; j < i; ++j) out.hessian[j * n + i] = out.hessian[i * n + j];
  }
  fill_gradient(horizon, stages, out.gradient);
}

}  // namespace skybody::nmpc
