// A baseline that hovers: flies every robot to its task's goal, through whatever command its first
// controller takes. A yardstick for scenarios and plugins, not a controller to learn from: it reads
// the environment's true masses and rotor constants.
#pragma once

#include <span>
#include <vector>

#include "core/policy/arm.h"
#include "core/policy/policy.h"

namespace skybody {

/// Chooses actions for a whole environment; stateless, so it may serve any number of Simulations of
/// the same environment.
///
/// Position error -> desired acceleration (PD, critically damped, with the goal's own velocity and
/// acceleration where the task says them) -> thrust direction -> body rates
/// (proportional on the attitude error) -> collective thrust and body rates (ctbr), which are
/// turned into the command that the mode takes: ctbt by a rate loop through the inertia, single
/// thrusts, rotor speeds and throttles by the pseudo-inverse of the rotors' geometry, a wrench by
/// rotation to W, velocity and pose directly, a trajectory by the goal's motion, which goes on with
/// the present acceleration. All loops are slower where the rotors are. A goal
/// about a body that hangs from the base, or stands on it, is reached by placing the four poles of
/// a pendulum on an accelerated pivot. What has no rotors and hangs on robots by rods, ropes or
/// points is carried by them in equal shares. A goal about a body that joints with position drives
/// move is reached by them from the scenario's place of the base; the base is flown by what they
/// lack, and the rotors bear the arm's weight.
class HoldPolicy : public Policy {
 public:
  /// @throws Error naming the robot if its command is none of the above
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
    Arm arm;                           ///< from the base to what the goal is about
    Vec3<double> tool{0.0, 0.0, 0.0};  ///< what is brought there, frame of the goal's body [m]
    double cable = 0.0;  ///< from the base's origin down to the tool [m]; less than 0: it stands
    int signal = 0;      ///< SkybodySignal
    int action = 0;
    double spacing = 0.0;     ///< of a trajectory's points [s]
    double load_share = 0.0;  ///< of the bodies in `loads`
    std::vector<int> loads;   ///< world body indices: what hangs on it by couplings
    std::vector<double> low, high;
    std::vector<double> joints;      ///< commands of a chain that drives joints, arms apart
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
