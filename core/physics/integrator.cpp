#include "core/physics/integrator.h"

#include <vector>

#include "core/physics/step_rules.h"

namespace skybody {
namespace {

class SemiImplicitEuler final : public Integrator {
 public:
  explicit SemiImplicitEuler(const World& world)
      : dt_(world.scenario.stepping.dt), qdot_(world.layout.q.size), udot_(world.layout.u.size) {}

  void advance(Mechanics& mechanics, double* q, double* u) override {
    semi_implicit_euler(mechanics, dt_, static_cast<int>(qdot_.size()),
                        static_cast<int>(udot_.size()), q, u, qdot_.data(), udot_.data());
  }

 private:
  double dt_;
  std::vector<double> qdot_, udot_;
};

class RungeKutta4 final : public Integrator {
 public:
  explicit RungeKutta4(const World& world)
      : dt_(world.scenario.stepping.dt), q_(world.layout.q.size), u_(world.layout.u.size) {
    stage_.q = q_.data();
    stage_.u = u_.data();
    for (int k = 0; k < 4; ++k) {
      qdot_[k].resize(q_.size());
      udot_[k].resize(u_.size());
      stage_.qdot[k] = qdot_[k].data();
      stage_.udot[k] = udot_[k].data();
    }
  }

  void advance(Mechanics& mechanics, double* q, double* u) override {
    runge_kutta_4(mechanics, dt_, static_cast<int>(q_.size()), static_cast<int>(u_.size()), q, u,
                  stage_);
  }

 private:
  double dt_;
  std::vector<double> q_, u_;
  std::vector<double> qdot_[4], udot_[4];
  StageArrays<double> stage_;  ///< into the vectors
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
    case IntegratorChoice::kCvode:
      return make_cvode(world);
    case IntegratorChoice::kArkode:
      return make_arkode(world);
  }
  return nullptr;
}

}  // namespace skybody
