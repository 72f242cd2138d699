#include "core/physics/integrator.h"

#include <vector>

namespace skybody {
namespace {

/// out = x + h rate
void step_from(const double* x, double h, const std::vector<double>& rate,
               std::vector<double>& out) {
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = x[i] + h * rate[i];
}

class SemiImplicitEuler final : public Integrator {
 public:
  explicit SemiImplicitEuler(const World& world)
      : dt_(world.scenario.stepping.dt), qdot_(world.layout.q.size), udot_(world.layout.u.size) {}

  void advance(Mechanics& mechanics, double* q, double* u) override {
    mechanics.mean_accelerations(q, u, udot_.data());
    for (std::size_t i = 0; i < udot_.size(); ++i) u[i] += dt_ * udot_[i];
    mechanics.position_rates(q, u, qdot_.data());
    for (std::size_t i = 0; i < qdot_.size(); ++i) q[i] += dt_ * qdot_[i];
  }

 private:
  double dt_;
  std::vector<double> qdot_, udot_;
};

class RungeKutta4 final : public Integrator {
 public:
  explicit RungeKutta4(const World& world)
      : dt_(world.scenario.stepping.dt), q_(world.layout.q.size), u_(world.layout.u.size) {
    for (auto& rate : qdot_) rate.resize(q_.size());
    for (auto& rate : udot_) rate.resize(u_.size());
  }

  void advance(Mechanics& mechanics, double* q, double* u) override {
    rate(mechanics, q, u, kStepStart, 0);
    stage(mechanics, q, u, 0.5 * dt_, kStepMiddle, 1);
    stage(mechanics, q, u, 0.5 * dt_, kStepMiddle, 2);
    stage(mechanics, q, u, dt_, kStepEnd, 3);
    combine(qdot_, q_.size(), q);
    combine(udot_, u_.size(), u);
  }

 private:
  /// Rates number i, at (q, u).
  void rate(Mechanics& mechanics, const double* q, const double* u, StageTime time, int i) {
    mechanics.accelerations(q, u, time, udot_[i].data());
    mechanics.position_rates(q, u, qdot_[i].data());
  }
  /// Rates number i, from the start (q, u) along the rates before.
  void stage(Mechanics& mechanics, const double* q, const double* u, double h, StageTime time,
             int i) {
    step_from(q, h, qdot_[i - 1], q_);
    step_from(u, h, udot_[i - 1], u_);
    rate(mechanics, q_.data(), u_.data(), time, i);
  }
  void combine(const std::vector<double> (&k)[4], std::size_t size, double* x) const {
    for (std::size_t i = 0; i < size; ++i) {
      x[i] += (dt_ / 6.0) * ((k[0][i] + k[3][i]) + 2.0 * (k[1][i] + k[2][i]));
    }
  }

  double dt_;
  std::vector<double> q_, u_;  ///< a stage's point
  std::vector<double> qdot_[4], udot_[4];
};

}  // namespace

std::unique_ptr<Integrator> make_semi_implicit_euler(const World& world) {
  return std::make_unique<SemiImplicitEuler>(world);
}

std::unique_ptr<Integrator> make_rk4(const World& world) {
  return std::make_unique<RungeKutta4>(world);
}

std::unique_ptr<Integrator> make_integrator(const World& world) {
  switch (world.scenario.stepping.integrator) {
    case IntegratorChoice::kSemiImplicitEuler:
      return make_semi_implicit_euler(world);
    case IntegratorChoice::kRk4:
      return make_rk4(world);
  }
  return nullptr;
}

}  // namespace skybody
