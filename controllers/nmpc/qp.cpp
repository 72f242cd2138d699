// DAQP turns the program into a least-distance problem by H = R' R and adds and removes bounds one
// at a time. Only its core is used; api.c, which allocates, is not built. This file sets up the
// workspace instead: sizes as in allocate_daqp_workspace and allocate_daqp_ldp, for n variables
// with n simple bounds and no other constraints.
#include "controllers/nmpc/qp.h"

extern "C" {
#include <daqp.h>
#include <utils.h>
}

namespace skybody::nmpc {
namespace {

constexpr int kN = kMostInputs;

/// Size of DAQP's workspace for a program of kMostInputs variables.
struct Memory {
  DAQPSettings settings;
  int sense[kN], working_set[kN + 1], start[kN];
  c_float r_inverse[kN * (kN + 1) / 2], l[(kN + 1) * (kN + 2) / 2];
  c_float d_upper[kN], d_lower[kN], v[kN], scaling[kN], u[kN], x_old[kN];
  c_float lambda[kN + 1], lambda_star[kN + 1], d[kN + 1], x_ldl[kN + 1], z_ldl[kN + 1];
};

DAQPSettings settings_of(const QpProblem& problem) {
  DAQPSettings s{};
  s.primal_tol = DEFAULT_PRIM_TOL;
  s.dual_tol = DEFAULT_DUAL_TOL;
  s.zero_tol = DEFAULT_ZERO_TOL;
  s.pivot_tol = DEFAULT_PIVOT_TOL;
  s.progress_tol = DEFAULT_PROG_TOL;
  s.cycle_tol = DEFAULT_CYCLE_TOL;
  s.iter_limit = problem.most_iterations + 1;  // DAQP counts from 1 to below the limit
  s.fval_bound = DAQP_INF;
  s.eps_prox = 0.0;
  s.eta_prox = DEFAULT_ETA;
  s.rho_soft = DEFAULT_RHO_SOFT;
  s.rel_subopt = DEFAULT_REL_SUBOPT;
  s.abs_subopt = DEFAULT_ABS_SUBOPT;
  s.sing_tol = DEFAULT_SING_TOL;
  s.refactor_tol = DEFAULT_REFACTOR_TOL;
  return s;
}

int sense_of(QpBound bound) {
  if (bound == QpBound::kLower) return ACTIVE | LOWER;
  return bound == QpBound::kUpper ? ACTIVE : 0;
}

DAQPProblem program_of(const QpProblem& problem, Memory& memory) {
  for (int i = 0; i < problem.size; ++i) memory.start[i] = sense_of(problem.start[i]);
  DAQPProblem qp{};
  qp.n = qp.m = qp.ms = problem.size;
  qp.H = problem.hessian;
  qp.f = problem.gradient;
  qp.bupper = problem.high;
  qp.blower = problem.low;
  qp.sense = memory.start;
  return qp;
}

DAQPWorkspace workspace_of(int size, Memory& memory) {
  DAQPWorkspace work{};
  work.n = work.m = work.ms = size;
  work.dupper = memory.d_upper;
  work.dlower = memory.d_lower;
  work.Rinv = memory.r_inverse;
  work.v = memory.v;
  work.sense = memory.sense;
  work.scaling = memory.scaling;
  work.x = work.u = memory.u;
  work.xold = memory.x_old;
  work.lam = memory.lambda;
  work.lam_star = memory.lambda_star;
  work.L = memory.l;
  work.D = memory.d;
  work.xldl = memory.x_ldl;
  work.zldl = memory.z_ldl;
  work.WS = memory.working_set;
  work.settings = &memory.settings;
  work.sing_ind = EMPTY_IND;
  for (int i = 0; i < size; ++i) memory.scaling[i] = 1.0;  // as in allocate_daqp_ldp
  return work;
}

}  // namespace

QpResult solve(const QpProblem& problem, double* solution) {
  Memory memory;
  memory.settings = settings_of(problem);
  DAQPProblem qp = program_of(problem, memory);
  DAQPWorkspace work = workspace_of(problem.size, memory);
  const int mask = UPDATE_Rinv | UPDATE_M | UPDATE_v | UPDATE_d | UPDATE_sense;
  if (update_ldp(mask, &work, &qp) < 0) return {false, 0};
  const int flag = daqp_ldp(&work);
  if (flag != EXIT_OPTIMAL) return {false, work.iterations};
  ldp2qp_solution(&work);
  for (int i = 0; i < problem.size; ++i) solution[i] = work.x[i];
  return {true, work.iterations};
}

}  // namespace skybody::nmpc
