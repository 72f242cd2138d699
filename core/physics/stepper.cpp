#include "core/physics/stepper.h"

#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/math.h"
#include "core/model/marked_error.h"
#include "core/physics/free_robots.h"
#include "core/physics/free_stepper.h"
#include "core/physics/hand_over_dynamics.h"
#include "core/physics/integrator.h"
#include "core/physics/tree_dynamics.h"

namespace skybody {
namespace {

bool all_bounded(const std::vector<double>& values) {
  bool bounded = true;
  for (const double v : values) bounded = bounded & (abs(v) < kLargestState);  // false for NaN
  return bounded;
}

/// Works on copies of q, u and rotor speeds and hands them over when the step has succeeded.
class MechanicsStepper final : public Stepper {
 public:
  MechanicsStepper(const World& world, std::unique_ptr<Dynamics> dynamics)
      : mechanics_(world, std::move(dynamics)),
        integrator_(make_integrator(world)),
        q_(world.layout.q.size),
        u_(world.layout.u.size),
        rotor_speed_(world.rotors.size()) {}

  void update_bodies(LaneState& state) override {
    mechanics_.bodies(state.q.data(), state.u.data(), state.bodies.data());
  }

  bool advance(LaneState& state) override {
    if (!try_step(state)) return false;
    if (!all_bounded(q_) || !all_bounded(u_) || !all_bounded(rotor_speed_)) return false;
    copy(q_, state.q);
    copy(u_, state.u);
    copy(rotor_speed_, state.rotor_speed);
    update_bodies(state);
    return true;
  }

  bool was_on_simbody() const override { return mechanics_.is_on_simbody(); }

  void accelerations(const LaneState& state, double* udot) override {
    copy(state.q, q_);
    copy(state.u, u_);
    mechanics_.begin_step(state, q_.data(), u_.data());
    mechanics_.accelerations(q_.data(), u_.data(), kStepStart, udot);
  }

  void add_contacts(const LaneState& state, std::vector<Contact>& out) override {
    mechanics_.add_contacts(state, out);
  }

 private:
  static void copy(const std::vector<double>& from, std::vector<double>& to) {
    if (!from.empty()) std::memcpy(to.data(), from.data(), from.size() * sizeof(double));
  }

  /// Dynamics throw where they give up (a singular matrix, a NaN in a rotation, masses that no body
  /// has): a failed step, not the end of the program. Bugs (std::logic_error) and lack of memory
  /// are no such thing and pass.
  bool try_step(const LaneState& state) {
    try {
      copy(state.q, q_);
      copy(state.u, u_);
      mechanics_.begin_step(state, q_.data(), u_.data());
      integrator_->advance(mechanics_, q_.data(), u_.data());
      mechanics_.end_step(q_.data(), rotor_speed_.data());
      return true;
    } catch (const std::runtime_error&) {
      return false;
    }
  }

  Mechanics mechanics_;
  std::unique_ptr<Integrator> integrator_;
  std::vector<double> q_, u_, rotor_speed_;
};

}  // namespace

std::unique_ptr<Stepper> make_stepper(const World& world, std::unique_ptr<Dynamics> dynamics) {
  return std::make_unique<MechanicsStepper>(world, std::move(dynamics));
}

DynamicsUse chosen_dynamics(const World& world) {
  const Stepping& stepping = world.scenario.stepping;
  if (stepping.dynamics == DynamicsChoice::kSimbody) return DynamicsUse::kSimbody;
  const std::string why_not = why_not_tree(world);
  if (why_not.empty()) return DynamicsUse::kTree;
  if (stepping.dynamics == DynamicsChoice::kAuto) return DynamicsUse::kHandOver;
  throw MarkedError(stepping.dynamics_mark,
                    "`dynamics` is `tree`, but the world " + why_not +
                        ": bodies may touch, and contact other than with the ground is Simbody's; "
                        "use `auto` (tree while nothing is within reach) or `simbody`");
}

void check_world(const World& world) {
  const DynamicsUse use = chosen_dynamics(world);
  if (use != DynamicsUse::kSimbody) make_stepper(world);
  if (use != DynamicsUse::kTree) check_simbody(world);
}

std::unique_ptr<Stepper> make_stepper(const World& world) {
  const DynamicsUse use = chosen_dynamics(world);
  if (use == DynamicsUse::kSimbody) return make_simbody_stepper(world);
  if (use == DynamicsUse::kTree) return make_tree_stepper(world);
  if (FreeRobots::is_possible(world)) return make_free_stepper(world, use);
  return make_stepper(world, make_hand_over_dynamics(world));
}

std::unique_ptr<Stepper> make_tree_stepper(const World& world) {
  if (FreeRobots::is_possible(world)) return make_free_stepper(world, DynamicsUse::kTree);
  return make_stepper(world, make_tree_dynamics(world));
}

std::unique_ptr<Stepper> make_simbody_stepper(const World& world) {
  return make_stepper(world, make_simbody_dynamics(world));
}

}  // namespace skybody
