#include "core/physics/integrator.h"

#include <vector>

namespace skybody {
namespace {

/// out = x + h rate
void step_from(const std::vector<double>& x, double h, const std::vector<double>& rate,
               std::vector<double>& out) {
  for (std::size_t i = 0; i < x.size(); ++i) out[i] = x[i] + h * rate[i];
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
      : dt_(world.scenario.stepping.dt),
        q0_(world.layout.q.size),
        q_(q0_.size()),
        u0_(world.layout.u.size),
        u_(u0_.size()) {
    for (auto& rate : qdot_) rate.resize(q0_.size());
    for (auto& rate : udot_) rate.resize(u0_.size());
  }

  void advance(Mechanics& mechanics, double* q, double* u) override {
    q0_.assign(q, q + q0_.size());
    u0_.assign(u, u + u0_.size());
    q_ = q0_;
    u_ = u0_;
    rate(mechanics, 0, kStepStart);
    move(0, 0.5 * dt_);
    rate(mechanics, 1, kStepMiddle);
    move(1, 0.5 * dt_);
    rate(mechanics, 2, kStepMiddle);
    move(2, dt_);
    rate(mechanics, 3, kStepEnd);
    combine(q0_, qdot_, q);
    combine(u0_, udot_, u);
  }

 private:
  /// Stage i's rates at the present stage point.
  void rate(Mechanics& mechanics, int i, StageTime time) {
    mechanics.accelerations(q_.data(), u_.data(), time, udot_[i].data());
    mechanics.position_rates(q_.data(), u_.data(), qdot_[i].data());
  }
  /// The next stage point: from the start along stage i's rates.
  void move(int i, double h) {
    step_from(q0_, h, qdot_[i], q_);
    step_from(u0_, h, udot_[i], u_);
  }
  void combine(const std::vector<double>& x0, const std::vector<double> (&k)[4],
               double* out) const {
    for (std::size_t i = 0; i < x0.size(); ++i) {
      out[i] = x0[i] + (dt_ / 6.0) * ((k[0][i] + k[3][i]) + 2.0 * (k[1][i] + k[2][i]));
    }
  }

  double dt_;
  std::vector<double> q0_, q_, u0_, u_;
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
