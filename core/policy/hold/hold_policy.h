// A baseline that hovers: flies every robot to its task's goal, through the command of its first
// controller. A reference for scenarios and plugins, not a controller to learn from: it reads the
// environment's true masses and rotor constants.
#pragma once

#include <span>
#include <vector>

#include "core/policy/hold/arm.h"
#include "core/policy/policy.h"

namespace skybody {

/// Chooses actions for a whole environment. Stateless, so it may serve any number of Simulations of
/// the same environment.
///
/// Control law:
///
/// 1. Position error -> desired acceleration: PD, critically damped, with the goal's own velocity
///    and acceleration if the task provides them.
/// 2. Desired acceleration -> thrust direction -> body rates, proportional to the attitude error.
/// 3. Result: collective thrust and body rates (ctbr).
///
/// Conversion to the other control modes: ctbt by a rate loop through the inertia; single thrusts,
/// rotor speeds and throttles by the pseudo-inverse of the rotors' geometry; a wrench by rotation
/// to W; velocity and pose directly; a trajectory by the goal's motion, continued with the present
/// acceleration. All loops are slower with slow rotors.
///
/// Goals of bodies other than the base:
///
/// - A body that hangs from the base, or stands on it: by placing the four poles of a pendulum on
///   an accelerated pivot.
/// - Robots without rotors that hang on others by rods, ropes or points: these carry them in equal
///   shares.
/// - A body moved by joints with position drives: the arm reaches the goal from the scenario's
///   place of the base; the base flies the rest of the way, and the rotors compensate the arm's
///   weight.
class HoldPolicy : public Policy {
 public:
  /// @throws Error with the robot's name if its command is none of the above
  explicit HoldPolicy(const CompiledScenario& compiled);

  void act(const Simulation& simulation, std::span<float> action) override;

 private:
  struct Robot {
    int index = 0;
    int base = 0;  ///< world body index
    int body_count = 0;
    int goal = -1;                     ///< index of its goal, -1: its pose at reset
    int goal_body = 0;                 ///< world body index
    bool swings = false;               ///< the goal's body is not the base, and no arm moves it
    Arm arm;                           ///< from the base to the goal's body
    Vec3<double> tool{0.0, 0.0, 0.0};  ///< point that is brought to the goal, frame of the goal's
                                       ///< body [m]
    double cable = 0.0;                ///< tool below the base's origin [m]; < 0: above
    int signal = 0;                    ///< SkybodySignal
    int action = 0;
    double spacing = 0.0;     ///< of a trajectory's points [s]
    double load_share = 0.0;  ///< share of the weight of `loads`
    std::vector<int> loads;   ///< world body indices of loads that hang on it by couplings
    std::vector<double> low, high;
    std::vector<double> joints;      ///< commands of a chain that drives joints, without arms
    std::vector<JointDrive> drives;  ///< of that chain
  };
  struct Setpoint;
  struct View;
  Robot commanded_robot(const ControllerChain& chain) const;
  void take_goal(Robot& robot) const;
  void check(const Robot& robot) const;
  void share_loads();
  View view_of(const Robot& robot, const KnownState& now, const std::vector<double>& goals,
               const std::vector<double>& motions) const;
  Vec3<double> gravity_of(const std::vector<double>& params) const;
  double nominal_weight(const Robot& robot) const;
  void share_reach(const Robot& robot, const View& view, Setpoint& setpoint) const;
  Vec3<double> torque_of_arm(const Robot& robot, const View& view, double thrust) const;
  std::vector<double> joint_commands(const Robot& robot, const View& view,
                                     const Setpoint& setpoint) const;
  Setpoint setpoint(const Robot& robot, const View& view) const;
  Vec3<double> acceleration(const Robot& robot, const View& view, const Setpoint& setpoint) const;
  Vec3<double> swing(const Robot& robot, const View& view, const Setpoint& setpoint) const;
  std::vector<double> command(const Robot& robot, const View& view, const Setpoint& setpoint) const;
  std::vector<double> rotor_thrusts(const Robot& robot, const View& view,
                                    const Setpoint& setpoint) const;
  std::vector<double> rotor_speeds(const Robot& robot, const View& view,
                                   const Setpoint& setpoint) const;
  std::vector<double> trajectory(const Robot& robot, const Setpoint& setpoint) const;
  const double* rotor_params(const Robot& robot, const View& view, std::size_t i) const;
  std::vector<double> wrench(const Robot& robot, const View& view, const Setpoint& setpoint) const;

  const CompiledScenario& compiled_;
  std::vector<Robot> robots_;
};

}  // namespace skybody
