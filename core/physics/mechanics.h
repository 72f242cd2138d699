// The equations of motion of one environment: kinematics, forces and dynamics put together into
// udot(q, u, t), for integrators.
#pragma once

#include <memory>
#include <vector>

#include "core/physics/dynamics.h"
#include "core/physics/force_model.h"

namespace skybody {

/// Equations of motion. Holds caches and work space only: no result depends on earlier calls other
/// than begin_step. Refers to the world, which must outlive it.
class Mechanics {
 public:
  Mechanics(const World& world, std::unique_ptr<Dynamics> dynamics);

  const World& world() const { return world_; }

  /// Fixes what a step holds: parameters, commands, wrenches and drives of `state`, which must not
  /// change until the step is done; and how the rotors run through it.
  /// @param q, u  coordinates at the start: those of `state`, where drives write their u
  void begin_step(const LaneState& state, const double* q, double* u);

  /// Whether Simbody computes what the step under way asks for.
  bool is_on_simbody() const { return dynamics_->is_on_simbody(); }

  /// udot with the rotors at an instant of the step.
  void accelerations(const double* q, const double* u, StageTime time, double* udot);

  /// udot with the rotors at a time since the start of the step [s].
  void accelerations_at(const double* q, const double* u, double time, double* udot);

  /// udot with the rotors at mid-step speed, accelerating by their mean: for one evaluation a step.
  void mean_accelerations(const double* q, const double* u, double* udot);

  /// qdot = N(q) u.
  void position_rates(const double* q, const double* u, double* qdot) const;

  /// Quaternions to norm 1, pose-driven bases exactly where they were told to be. Writes the
  /// rotors' speed at the step's end.
  void end_step(double* q, double* rotor_speed) const;

  /// Appends the contacts that the dynamics computes at q and u of `state`.
  void add_contacts(const LaneState& state, std::vector<Contact>& out);

  /// Motion of all bodies.
  void bodies(const double* q, const double* u, BodyState* out);

 private:
  /// A driven base.
  struct Drive {
    DriveKind kind = DriveKind::kNone;
    int body = 0;
    int value = 0;     ///< first of its values within the drive block
    double target[7];  ///< pose drives: coordinates at the step's end
  };

  void update_lag(const double* params);
  void run_rotors(const LaneState& state);
  /// Makes `motion_` belong to q and u: the end of one step is the start of the next.
  void update_motion(const double* q, const double* u);
  void start_drives(const LaneState& state, const double* q, double* u);
  void accelerations(const double* q, const double* u, const RotorMotion<double>* rotors,
                     double* udot);

  const World& world_;
  std::vector<TreeBody> tree_;
  ForceModel force_model_;
  std::unique_ptr<Dynamics> dynamics_;
  std::vector<Drive> drives_;

  std::vector<double> lag_params_;  ///< rotor constants that `lag_` was made from
  std::vector<RotorLag<double>> lag_;

  const LaneState* state_ = nullptr;                          ///< of the step under way
  std::vector<RotorMotion<double>> rotors_[kStageTimeCount];  ///< per instant of the step
  std::vector<RotorMotion<double>> mean_rotors_;
  std::vector<RotorMotion<double>> rotors_at_time_;
  std::vector<BodyKinematics<double>> motion_;
  std::vector<double> motion_q_, motion_u_;  ///< what `motion_` was computed from
  bool has_motion_ = false;
  std::vector<SpatialForce<double>> body_forces_;
  std::vector<double> joint_forces_;
};

}  // namespace skybody
