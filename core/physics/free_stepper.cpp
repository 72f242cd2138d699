#include "core/physics/free_stepper.h"

#include <cstring>
#include <stdexcept>

#include "core/physics/free_robot_step.h"
#include "core/physics/hand_over_dynamics.h"
#include "core/physics/pack_world.h"
#include "core/physics/reach.h"
#include "core/physics/tree_dynamics.h"

namespace skybody {
namespace {

class FreeStepper final : public Stepper {
 public:
  FreeStepper(const World& world, DynamicsUse use)
      : robots_(world),
        is_rk4_(world.scenario.stepping.integrator == IntegratorChoice::kRk4),
        reach_(world),
        hands_over_(use == DynamicsUse::kHandOver && reach_.is_possible()),
        tree_(make_tree(world)),
        kinematics_(world.bodies.size()),
        swept_(reach_.sphere_count()),
        derived_layout_(world),
        derived_(static_cast<std::size_t>(derived_layout_.size)),
        motions_(robots_.robots.size()),
        end_speeds_(robots_.rotors.size()),
        general_(make_stepper(world, use == DynamicsUse::kHandOver ? make_hand_over_dynamics(world)
                                                                   : make_tree_dynamics(world))) {
    made_from_.reserve(static_cast<std::size_t>(world.layout.params.size));
  }

  void update_bodies(LaneState& state) override { general_->update_bodies(state); }

  bool advance(LaneState& state) override {
    is_on_simbody_ = hands_over_ && is_within_reach(state);
    if (is_on_simbody_) return general_->advance(state);
    if (!take_params(state.params)) return false;
    bool through = true;
    for (std::size_t r = 0; r < robots_.robots.size(); ++r) {
      const FreeRobot& robot = robots_.robots[r];
      const double *q = state.q.data() + robot.q, *u = state.u.data() + robot.u;
      const auto load = [&] {
        return FreeMotion<double>{load_vec3(q), load_quat(q + 3), load_vec3(u), load_vec3(u + 3)};
      };
      const Step::Inputs in{state.rotor_speed.data(),
                            state.rotor_command.data(),
                            state.wrench.data(),
                            state.params.data(),
                            derived_.data() + derived_layout_.lags,
                            derived_.data() + derived_layout_.factors,
                            derived_.data() + derived_layout_.bodies};
      const Step step(robots_, robot, in);
      double* end_speeds = end_speeds_.data() + robot.rotors.first;
      through &= is_rk4_ ? step.advance<IntegratorChoice::kRk4>(load, motions_[r], end_speeds)
                         : step.advance<IntegratorChoice::kSemiImplicitEuler>(load, motions_[r],
                                                                              end_speeds);
    }
    if (through) store(state);
    return through;
  }

  bool was_on_simbody() const override { return is_on_simbody_; }

  void accelerations(const LaneState& state, double* udot) override {
    is_on_simbody_ = hands_over_ && is_within_reach(state);
    general_->accelerations(state, udot);
  }

  void add_contacts(const LaneState& state, std::vector<Contact>& out) override {
    general_->add_contacts(state, out);
  }

 private:
  using Step = FreeRobotStep<double, const double*, const double*, const double*, 0>;

  bool is_within_reach(const LaneState& state) {
    forward_kinematics(tree_, state.q.data(), state.u.data(), kinematics_.data());
    return reach_.is_within(kinematics_.data(), swept_.data());
  }

  /// @returns whether there are bodies with such masses
  bool take_params(const std::vector<double>& params) {
    if (params.size() == made_from_.size() &&
        std::memcmp(params.data(), made_from_.data(), params.size() * sizeof(double)) == 0) {
      return true;
    }
    made_from_.clear();
    try {
      derive(robots_.world, derived_layout_, params.data(), derived_.data());
    } catch (const std::runtime_error&) {
      return false;
    }
    made_from_ = params;
    return true;
  }

  void store(LaneState& state) const {
    for (std::size_t r = 0; r < robots_.robots.size(); ++r) {
      const FreeRobot& robot = robots_.robots[r];
      const FreeMotion<double>& m = motions_[r];
      skybody::store(m.position, state.q.data() + robot.q);
      skybody::store(m.rotation, state.q.data() + robot.q + 3);
      skybody::store(m.velocity, state.u.data() + robot.u);
      skybody::store(m.spin, state.u.data() + robot.u + 3);
      state.bodies[static_cast<std::size_t>(robot.body)] = {m.position, m.rotation, m.velocity,
                                                            m.spin};
    }
    if (end_speeds_.empty()) return;
    std::memcpy(state.rotor_speed.data(), end_speeds_.data(), end_speeds_.size() * sizeof(double));
  }

  FreeRobots robots_;
  bool is_rk4_;
  Reach reach_;
  bool hands_over_, is_on_simbody_ = false;
  std::vector<TreeBody> tree_;
  std::vector<BodyKinematics<double>> kinematics_;
  std::vector<SweptSphere<double>> swept_;
  DerivedLayout derived_layout_;
  std::vector<double> derived_;
  std::vector<double> made_from_;  ///< parameters that `derived_` belongs to; empty: none
  std::vector<FreeMotion<double>> motions_;
  std::vector<double> end_speeds_;
  std::unique_ptr<Stepper> general_;  ///< for what is no step
};

}  // namespace

std::unique_ptr<Stepper> make_free_stepper(const World& world, DynamicsUse use) {
  return std::make_unique<FreeStepper>(world, use);
}

}  // namespace skybody
