// The guide's model and program: derivatives, condensing, bounds.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>
#include <vector>

#include "controllers/nmpc/condense.h"
#include "controllers/nmpc/solver.h"

namespace skybody::nmpc {
namespace {

class Draw {
 public:
  explicit Draw(unsigned seed) : generator_(seed) {}
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(generator_);
  }
  Vec3<double> vec3(double most) {
    return {(*this)(-most, most), (*this)(-most, most), (*this)(-most, most)};
  }

 private:
  std::mt19937_64 generator_;
};

/// Five tilted rotors with different lags on a body without symmetry.
Model any_model(Draw& draw) {
  Model model;
  model.rotors = 5;
  for (int i = 0; i < model.rotors; ++i) {
    model.rotor[i] = {{draw(-1, 1), draw(-1, 1), draw(4, 8)},
                      draw.vec3(40.0),
                      draw(0.01, 0.05),
                      draw(0.01, 0.05)};
  }
  model.gravity = {0.0, 0.0, -9.81};
  model.drag = {draw(0, 0.5), draw(0, 0.5), draw(0, 0.5)};
  const SymMat3<double> inertia{0.015, 0.017, 0.029, 0.001, -0.002, 0.0015};
  model.inertia = to_mat3(inertia);
  model.inverse_inertia = to_mat3(inverse(inertia));
  return model;
}

Motion any_motion(Draw& draw, int rotors) {
  Motion motion{
      draw.vec3(3.0), draw.vec3(5.0), from_rotation_vector(draw.vec3(1.5)), draw.vec3(6.0), {}};
  for (int i = 0; i < rotors; ++i) motion.share[i] = draw(0.0, 1.0);
  return motion;
}

/// Tangents of `to` from `from`: position, velocity, rotation in axes of `from`, rates, shares.
Eigen::VectorXd difference(const Motion& to, const Motion& from, int rotors) {
  Eigen::VectorXd out(12 + rotors);
  const Quat<double> turn = conjugate(from.rotation) * to.rotation;
  const Vec3<double> p = to.position - from.position, v = to.velocity - from.velocity,
                     w = to.rates - from.rates;
  out.head(12) << p.x, p.y, p.z, v.x, v.y, v.z, 2 * turn.x, 2 * turn.y, 2 * turn.z, w.x, w.y, w.z;
  for (int i = 0; i < rotors; ++i) out(12 + i) = to.share[i] - from.share[i];
  return out;
}

Motion moved(Motion motion, int tangent, double by) {
  Vec3<double> turn{0, 0, 0};
  double* const places[] = {&motion.position.x,
                            &motion.position.y,
                            &motion.position.z,
                            &motion.velocity.x,
                            &motion.velocity.y,
                            &motion.velocity.z,
                            &turn.x,
                            &turn.y,
                            &turn.z,
                            &motion.rates.x,
                            &motion.rates.y,
                            &motion.rates.z};
  *(tangent < 12 ? places[tangent] : &motion.share[tangent - 12]) += by;
  motion.rotation = motion.rotation * from_rotation_vector(turn);
  return motion;
}

/// A step's derivatives as dense matrices A and B.
struct Dense {
  Eigen::MatrixXd a, b;
};

Eigen::Matrix3d dense(const Mat3<double>& m) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.m);
}

Dense dense(const StepJacobian& j, double h, int rotors) {
  Dense out{Eigen::MatrixXd::Zero(12 + rotors, 12 + rotors),
            Eigen::MatrixXd::Zero(12 + rotors, rotors)};
  out.a.block<3, 3>(3, 3) = dense(j.v_v);
  out.a.block<3, 3>(3, 6) = dense(j.v_t);
  out.a.block<3, 3>(3, 9) = dense(j.v_w);
  out.a.block<3, 3>(6, 6) = dense(j.t_t);
  out.a.block<3, 3>(6, 9) = dense(j.t_w);
  out.a.block<3, 3>(9, 9) = dense(j.w_w);
  for (int r = 0; r < rotors; ++r) {
    for (int i = 0; i < 3; ++i) {
      out.a(3 + i, 12 + r) = j.v_f[i][r], out.b(3 + i, r) = j.v_u[i][r];
      out.a(6 + i, 12 + r) = j.t_f[i][r], out.b(6 + i, r) = j.t_u[i][r];
      out.a(9 + i, 12 + r) = j.w_f[i][r], out.b(9 + i, r) = j.w_u[i][r];
    }
    out.a(12 + r, 12 + r) = j.f_f[r];
    out.b(12 + r, r) = 1.0 - j.f_f[r];
  }
  out.a.topRows(3) = 0.5 * h * out.a.middleRows(3, 3);
  out.b.topRows(3) = 0.5 * h * out.b.middleRows(3, 3);
  out.a.block<3, 3>(0, 0) += Eigen::Matrix3d::Identity();
  out.a.block<3, 3>(0, 3) += 0.5 * h * Eigen::Matrix3d::Identity();
  return out;
}

TEST(NmpcModel, DerivativesAreThoseOfCentralDifferences) {
  Draw draw(1);
  constexpr double kBy = 1e-5;
  for (int round = 0; round < 50; ++round) {
    const Model model = any_model(draw);
    const double h = draw(0.005, 0.1);
    const StepLength step = step_length(model, h);
    const Disturbance disturbance{draw.vec3(2.0), draw.vec3(5.0)};
    const Motion from = any_motion(draw, model.rotors);
    double command[kMostRotors];
    for (int r = 0; r < model.rotors; ++r) command[r] = draw(0.0, 1.0);
    StepJacobian j;
    Motion to = from;
    advance(model, step, command, disturbance, to, &j);
    const Dense want = dense(j, h, model.rotors);
    const auto column = [&](const Motion& up, const Motion& down) {
      return Eigen::VectorXd(
          (difference(up, to, model.rotors) - difference(down, to, model.rotors)) / (2.0 * kBy));
    };
    // The differences' own error: third derivatives times kBy^2, and rounding over kBy; both 1e-9.
    for (int k = 0; k < 12 + model.rotors; ++k) {
      Motion up = moved(from, k, kBy), down = moved(from, k, -kBy);
      advance(model, step, command, disturbance, up, nullptr);
      advance(model, step, command, disturbance, down, nullptr);
      EXPECT_LT((column(up, down) - want.a.col(k)).norm(), 1e-7)
          << "round " << round << ", by " << k;
    }
    for (int r = 0; r < model.rotors; ++r) {
      Motion up = from, down = from;
      const double before = command[r];
      command[r] = before + kBy;
      advance(model, step, command, disturbance, up, nullptr);
      command[r] = before - kBy;
      advance(model, step, command, disturbance, down, nullptr);
      command[r] = before;
      EXPECT_LT((column(up, down) - want.b.col(r)).norm(), 1e-7)
          << "round " << round << ", u " << r;
    }
  }
}

/// Error of one step of length h against many small ones. All rotors speed up throughout, so the
/// lags' time constants are constant.
double step_error(double h) {
  Draw draw(2);
  const Model model = any_model(draw);
  Motion coarse = any_motion(draw, model.rotors);
  double command[kMostRotors];
  for (int r = 0; r < model.rotors; ++r) coarse.share[r] = 0.2 + 0.05 * r, command[r] = 0.9;
  Motion fine = coarse;
  constexpr int kSteps = 2000;
  const StepLength small = step_length(model, h / kSteps);
  for (int i = 0; i < kSteps; ++i) advance(model, small, command, {}, fine, nullptr);
  advance(model, step_length(model, h), command, {}, coarse, nullptr);
  return difference(coarse, fine, model.rotors).norm();
}

TEST(NmpcModel, AStepIsOfSecondOrder) {
  // The error of a second-order step falls by 8 when its length is halved, if the length is far
  // below the lags (10 ms or more); 6 leaves room for the terms of higher order.
  EXPECT_GT(step_error(0.002) / step_error(0.001), 6.0);
  EXPECT_GT(step_error(0.001) / step_error(0.0005), 6.0);
}

TEST(NmpcModel, RotorsLagInClosedForm) {
  Draw draw(3);
  const Model model = any_model(draw);
  Motion motion = any_motion(draw, model.rotors);
  const double up = motion.share[0] * 0.5 + 0.5, down = motion.share[1] * 0.5;
  const double command[kMostRotors] = {up, down};
  const Motion from = motion;
  advance(model, step_length(model, 0.03), command, {}, motion, nullptr);
  EXPECT_NEAR(motion.share[0], up + (from.share[0] - up) * std::exp(-0.03 / model.rotor[0].tau_up),
              1e-15);
  EXPECT_NEAR(motion.share[1],
              down + (from.share[1] - down) * std::exp(-0.03 / model.rotor[1].tau_down), 1e-15);
}

TEST(NmpcCondense, ProgramIsThatOfDenseAlgebra) {
  Draw draw(4);
  const Model model = any_model(draw);
  const Horizon horizon{6, model.rotors, 0.05, 2.5};
  const StepLength step = step_length(model, horizon.node_step);
  const int n = horizon.nodes * model.rotors, states = 12 + model.rotors;
  std::vector<Stage> stages(6);
  Eigen::MatrixXd by_inputs = Eigen::MatrixXd::Zero(states, n);
  Eigen::MatrixXd hessian = 2.5 * Eigen::MatrixXd::Identity(n, n);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
  Motion motion = any_motion(draw, model.rotors);
  for (int k = 0; k < horizon.nodes; ++k) {
    Stage& stage = stages[static_cast<std::size_t>(k)];
    double command[kMostRotors];
    for (int r = 0; r < model.rotors; ++r) command[r] = draw(0.0, 1.0);
    advance(model, step, command, {}, motion, &stage.step);
    stage.position = {draw(1, 9), draw(1, 9), draw(1, 9)};
    stage.velocity = {draw(1, 9), draw(1, 9), draw(1, 9)};
    stage.rates = {draw(1, 9), draw(1, 9), draw(1, 9)};
    stage.attitude = to_mat3(SymMat3<double>{5, 6, 7, 1, -1, 0.5});
    Eigen::MatrixXd q = Eigen::MatrixXd::Zero(states, states);
    q.diagonal().head(12) << stage.position.x, stage.position.y, stage.position.z, stage.velocity.x,
        stage.velocity.y, stage.velocity.z, 0, 0, 0, stage.rates.x, stage.rates.y, stage.rates.z;
    q.block<3, 3>(6, 6) = dense(stage.attitude);
    Eigen::VectorXd linear = Eigen::VectorXd::Zero(states);
    for (int i = 0; i < 12; ++i) linear(i) = stage.gradient[i] = draw(-3, 3);
    const Dense j = dense(stage.step, horizon.node_step, model.rotors);
    by_inputs = j.a * by_inputs;
    by_inputs.middleCols(k * model.rotors, model.rotors) = j.b;
    hessian += by_inputs.transpose() * q * by_inputs;
    gradient += by_inputs.transpose() * linear;
    for (int r = 0; r < model.rotors; ++r) {
      gradient(k * model.rotors + r) += stage.input_gradient[r] = draw(-1, 1);
    }
  }
  const auto got = std::make_unique<Condensed>();
  condense(horizon, stages.data(), *got);
  const Eigen::Map<const Eigen::MatrixXd> h(got->hessian, n, n);
  const Eigen::Map<const Eigen::VectorXd> g(got->gradient, n);
  EXPECT_LT((h - hessian).norm(), 1e-12 * hessian.norm());  // rounding
  EXPECT_LT((g - gradient).norm(), 1e-12 * gradient.norm());
}

/// A random strictly convex program with bounds.
struct Program {
  int n;
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient, low, high;
  std::vector<QpBound> start;

  Program(int size, Draw& draw) : n(size), start(static_cast<std::size_t>(size), QpBound::kNone) {
    const auto any = [&] { return draw(-1.0, 1.0); };
    const Eigen::MatrixXd root = Eigen::MatrixXd::NullaryExpr(n, n, any);
    hessian = root.transpose() * root + 0.1 * Eigen::MatrixXd::Identity(n, n);
    gradient = 5.0 * Eigen::VectorXd::NullaryExpr(n, any);
    low = -Eigen::VectorXd::NullaryExpr(n, [&] { return draw(0.0, 0.5); });
    high = Eigen::VectorXd::NullaryExpr(n, [&] { return draw(0.01, 0.5); });
  }
  QpResult solve(Eigen::VectorXd& x, int most_iterations = 1000) {
    x.resize(n);
    return nmpc::solve({n, hessian.data(), gradient.data(), low.data(), high.data(), start.data(),
                        most_iterations},
                       x.data());
  }
};

TEST(NmpcProgram, SolutionsMeetTheConditionsOfOptimality) {
  // Necessary and sufficient: the gradient is 0 at free variables and points out of the box at
  // variables on a bound.
  Draw draw(5);
  for (const int n : {2, 7, 40, 80, 160}) {
    Program program(n, draw);
    Eigen::VectorXd x;
    ASSERT_TRUE(program.solve(x).is_solved) << n;
    const Eigen::VectorXd slope = program.hessian * x + program.gradient;
    int bound = 0;
    for (int i = 0; i < n; ++i) {
      // DAQP allows bounds to be exceeded by 1e-6; slopes follow with the Hessian's norm.
      EXPECT_GE(x(i), program.low(i) - 2e-6);
      EXPECT_LE(x(i), program.high(i) + 2e-6);
      const double tolerance = 1e-5 * program.hessian.norm();
      const bool at_low = x(i)<program.low(i) + 1e-5, at_high = x(i)> program.high(i) - 1e-5;
      bound += at_low || at_high ? 1 : 0;
      EXPECT_TRUE(at_low || slope(i) < tolerance) << n << ", variable " << i << ": " << slope(i);
      EXPECT_TRUE(at_high || slope(i) > -tolerance) << n << ", variable " << i << ": " << slope(i);
    }
    EXPECT_GT(bound, 0) << "the program tests no bounds";
  }
}

TEST(NmpcProgram, WhereItBeginsChangesNothingButTheWay) {
  Draw draw(6);
  Program program(60, draw);
  Eigen::VectorXd cold, warm;
  const QpResult first = program.solve(cold);
  for (int i = 0; i < program.n; ++i) {
    auto& start = program.start[static_cast<std::size_t>(i)];
    if (cold(i) < program.low(i) + 1e-9) start = QpBound::kLower;
    if (cold(i) > program.high(i) - 1e-9) start = QpBound::kUpper;
  }
  const QpResult second = program.solve(warm);
  ASSERT_TRUE(first.is_solved && second.is_solved);
  EXPECT_LT((cold - warm).norm(), 1e-9);
  EXPECT_LT(second.iterations, first.iterations / 4);
}

TEST(NmpcProgram, GivesUpWhereItMay) {
  Draw draw(7);
  Program program(60, draw);
  Eigen::VectorXd x;
  EXPECT_FALSE(program.solve(x, 3).is_solved);
  program.hessian(5, 5) = -1.0;
  EXPECT_FALSE(program.solve(x).is_solved) << "it is not convex";
}

TEST(NmpcTarget, OnePointLeadsToWhatItsPolynomialLeadsTo) {
  Draw draw(8);
  const ReferencePoint<double> point{draw.vec3(1), draw.vec3(1), draw.vec3(1), draw.vec3(1),
                                     draw.vec3(1), 0.3,          0.2};
  const double t = 0.7;
  const ReferencePoint<double> at = extrapolated(point, t);
  const double t2 = t * t / 2, t3 = t * t2 / 3, t4 = t * t3 / 4;
  EXPECT_LT(norm(at.position - (point.position + point.velocity * t + point.acceleration * t2 +
                                point.jerk * t3 + point.snap * t4)),
            1e-15);
  EXPECT_LT(norm(at.velocity -
                 (point.velocity + point.acceleration * t + point.jerk * t2 + point.snap * t3)),
            1e-15);
  EXPECT_LT(norm(at.acceleration - (point.acceleration + point.jerk * t + point.snap * t2)), 1e-15);
  EXPECT_LT(norm(at.jerk - (point.jerk + point.snap * t)), 1e-15);
  EXPECT_NEAR(at.yaw, 0.3 + 0.2 * t, 1e-15);
}

}  // namespace
}  // namespace skybody::nmpc
