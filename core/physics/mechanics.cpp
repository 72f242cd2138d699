#include "core/physics/mechanics.h"

#include <algorithm>
#include <cstring>

#include "core/base/error.h"
#include "core/physics/step_rules.h"

namespace skybody {
namespace {

/// NaN-proof "the same bits".
bool same_words(const double* a, const double* b, std::size_t count) {
  return count == 0 || std::memcmp(a, b, count * sizeof(double)) == 0;
}

}  // namespace

Mechanics::Mechanics(const World& world, std::unique_ptr<Dynamics> dynamics)
    : world_(world),
      tree_(make_tree(world)),
      force_model_(world),
      dynamics_(std::move(dynamics)),
      lag_params_(kRotorParamCount * world.rotors.size(), kNan),
      lag_(world.rotors.size()),
      mean_rotors_(world.rotors.size()),
      rotors_at_time_(world.rotors.size()),
      motion_(world.bodies.size()),
      motion_q_(world.layout.q.size),
      motion_u_(world.layout.u.size),
      body_forces_(world.bodies.size()),
      joint_forces_(world.layout.u.size, 0.0) {
  for (auto& rotors : rotors_) rotors.resize(world.rotors.size());
  int value = 0;
  for (std::size_t r = 0; r < world.drives.size(); ++r) {
    if (world.drives[r] == DriveKind::kNone) continue;
    const int base = world.layout.robots[r].first_body;
    if (tree_[base].type != JointType::kFree || tree_[base].parent >= 0) {
      throw Error("robot '" + world.scenario.robots[r].name +
                  "' has a fixed base, which cannot be driven; choose another controller");
    }
    drives_.push_back({world.drives[r], base, value, {}});
    value += kDriveSize;
  }
}

void Mechanics::begin_step(const LaneState& state, const double* q, double* u) {
  state_ = &state;
  update_motion(q, u);
  dynamics_->begin_step(motion_.data());
  dynamics_->set_params(state.params.data());
  update_lag(state.params.data());
  run_rotors(state);
  if (!drives_.empty()) start_drives(state, q, u);
}

void Mechanics::update_lag(const double* params) {
  if (lag_.empty()) return;
  // The constants of all rotors lie one after another (world_layout.cpp).
  const double* constants = params + world_.layout.rotor_params.front();
  if (same_words(constants, lag_params_.data(), lag_params_.size())) return;
  for (std::size_t i = 0; i < lag_.size(); ++i) {
    lag_[i] = make_rotor_lag(constants + kRotorParamCount * i, world_.scenario.stepping.dt);
  }
  std::memcpy(lag_params_.data(), constants, lag_params_.size() * sizeof(double));
}

void Mechanics::run_rotors(const LaneState& state) {
  for (std::size_t i = 0; i < lag_.size(); ++i) {
    const double* constants = state.params.data() + world_.layout.rotor_params[i];
    const RotorStep<double> rotor(lag_[i], state.rotor_speed[i], state.rotor_command[i],
                                  constants[kMaxSpeed]);
    for (const StageTime time : {kStepStart, kStepMiddle, kStepEnd}) {
      rotors_[time][i] = rotor.at(time);
    }
    mean_rotors_[i] = rotor.mean(rotors_[kStepEnd][i].speed, 1.0 / world_.scenario.stepping.dt);
  }
}

void Mechanics::update_motion(const double* q, const double* u) {
  if (has_motion_ && same_words(q, motion_q_.data(), motion_q_.size()) &&
      same_words(u, motion_u_.data(), motion_u_.size())) {
    return;
  }
  forward_kinematics(tree_, q, u, motion_.data());
  std::copy_n(q, motion_q_.size(), motion_q_.begin());
  std::copy_n(u, motion_u_.size(), motion_u_.begin());
  has_motion_ = true;
}

void Mechanics::start_drives(const LaneState& state, const double* q, double* u) {
  for (Drive& drive : drives_) {
    const TreeBody& base = tree_[drive.body];
    begin_drive(drive.kind, motion_[drive.body], state.drive.data() + drive.value,
                world_.scenario.stepping.dt, q + base.q, u + base.u, drive.target);
  }
}

void Mechanics::accelerations(const double* q, const double* u, StageTime time, double* udot) {
  accelerations(q, u, rotors_[time].data(), udot);
}

void Mechanics::accelerations_at(const double* q, const double* u, double time, double* udot) {
  for (std::size_t i = 0; i < rotors_at_time_.size(); ++i) {
    const double* constants = state_->params.data() + world_.layout.rotor_params[i];
    const double command = limit_command(state_->rotor_command[i], constants[kMaxSpeed]);
    rotors_at_time_[i] = rotor_at_time(constants, state_->rotor_speed[i], command, time,
                                       world_.scenario.stepping.dt);
  }
  accelerations(q, u, rotors_at_time_.data(), udot);
}

void Mechanics::mean_accelerations(const double* q, const double* u, double* udot) {
  accelerations(q, u, mean_rotors_.data(), udot);
}

void Mechanics::accelerations(const double* q, const double* u, const RotorMotion<double>* rotors,
                              double* udot) {
  update_motion(q, u);
  const ForceInputs<double> in{
      q, u, motion_.data(), rotors, state_->params.data(), state_->wrench.data()};
  force_model_.evaluate(in, body_forces_.data(), joint_forces_.data());
  dynamics_->accelerations(q, u, body_forces_.data(), joint_forces_.data(), udot);
}

void Mechanics::position_rates(const double* q, const double* u, double* qdot) const {
  for (const TreeBody& body : tree_) {
    skybody::position_rates(body.type, q + body.q, u + body.u, qdot + body.q);
  }
}

void Mechanics::end_step(double* q, double* rotor_speed) const {
  for (const TreeBody& body : tree_) normalize_position(body.type, q + body.q);
  for (const Drive& drive : drives_) {
    if (drive.kind != DriveKind::kPose) continue;
    std::memcpy(q + tree_[drive.body].q, drive.target, sizeof(drive.target));
  }
  for (std::size_t i = 0; i < lag_.size(); ++i) rotor_speed[i] = rotors_[kStepEnd][i].speed;
}

void Mechanics::add_contacts(const LaneState& state, std::vector<Contact>& out) {
  update_motion(state.q.data(), state.u.data());
  dynamics_->begin_step(motion_.data());
  dynamics_->set_params(state.params.data());
  dynamics_->add_contacts(state.q.data(), state.u.data(), out);
}

void Mechanics::bodies(const double* q, const double* u, BodyState* out) {
  update_motion(q, u);
  for (std::size_t i = 0; i < motion_.size(); ++i) out[i] = to_body_state(motion_[i]);
}

}  // namespace skybody
