// Mixer: thrust and torque, or a wrench, to rotors and servos by a matrix. For tricopters,
// bicopters and permanently tilted rotors.
#include <string>
#include <vector>

#include "controllers/common/composite_body.h"
#include "controllers/common/rotor_effects.h"
#include "controllers/common/servo.h"
#include "controllers/common/six_axis_inverse.h"

namespace skybody {
namespace {

class Mixer : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    takes_wrench_ = signal_.value() == "wrench";
    inputs_ = takes_wrench_ ? 6 : 4;
    const View<RotorInfo> rotors = control::working_rotors(setup, robot, "mixer");
    take_rotors(setup, robot, rotors);
    take_servos(setup, robot);
    declare_input(setup, robot);
    setup.output(Signal::kRotorSpeed, rotors.size());
    if (!servos_.empty()) setup.output(Signal::kJoint, static_cast<int>(servos_.size()));
  }

  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> input,
               Values<Real> output) const {
    const int rotors = static_cast<int>(rotors_.size());
    for (int i = 0; i < rotors; ++i) {
      const Rotor& rotor = rotors_[static_cast<std::size_t>(i)];
      const Real thrust = clamp(mixed(rotor.row, input), Real(rotor.least), Real(rotor.full));
      output.set(i, control::speed_for(thrust, rotor.least, rotor.per_constant));
    }
    for (std::size_t k = 0; k < servos_.size(); ++k) {
      const ServoRow& servo = servos_[k];
      Real place = mixed(servo.row, input) + servo.neutral;
      if (servo.joint.low < servo.joint.high) {
        place = clamp(place, Real(servo.joint.low), Real(servo.joint.high));
      }
      output.set(rotors + static_cast<int>(k), place);
    }
  }

 private:
  struct Rotor {
    std::vector<double> row;  ///< thrust [N] per value of the input
    double least, full;       ///< [N]
    double per_constant;      ///< 1 / k_f
  };
  struct ServoRow {
    control::DrivenJoint joint;
    std::vector<double> row;  ///< position [rad] or [m] per value of the input
    double neutral;           ///< [rad] or [m]
  };

  template <class Real>
  SKYBODY_INLINE Real mixed(const std::vector<double>& row, ConstValues<Real> input) const {
    Real sum = input[0] * row[0];
    for (int k = 1; k < inputs_; ++k) sum += input[k] * row[static_cast<std::size_t>(k)];
    return sum;
  }

  /// Row i of a matrix that is given row by row.
  std::vector<double> row_of(const RealsParameter& matrix, int i) const {
    std::vector<double> row;
    for (int k = 0; k < inputs_; ++k) row.push_back(matrix.value(inputs_ * i + k));
    return row;
  }

  void require_rows(const char* name, const RealsParameter& matrix, int rows,
                    const std::string& of) const {
    if (matrix.count() == rows * inputs_) return;
    refuse("`", name, "` has ", matrix.count(), " values; allowed: ", rows * inputs_, ", ", inputs_,
           " for each of the ", rows, " ", of);
  }

  void take_rotors(const Setup& setup, int robot, const View<RotorInfo>& rotors) {
    const bool is_given = matrix_.count() > 0;
    if (!is_given && !takes_wrench_) {
      refuse("`rotors`, the matrix, is not given: give ", rotors.size(),
             " rows of 4 values, or use `ctbt`, which finds its own for rotors on the base");
    }
    if (is_given) require_rows("rotors", matrix_, rotors.size(), "rotors");
    const control::SixAxisInverse inverse =
        is_given ? control::SixAxisInverse{} : inverse_of(setup, robot, rotors);
    for (int i = 0; i < rotors.size(); ++i) {
      Rotor rotor{{},
                  control::least_thrust(rotors[i]),
                  control::full_thrust(rotors[i]),
                  1.0 / rotors[i].constants[SKYBODY_ROTOR_THRUST_CONSTANT]};
      if (is_given) {
        rotor.row = row_of(matrix_, i);
      } else {
        const auto row = static_cast<std::size_t>(i);
        for (int k = 0; k < inputs_; ++k) rotor.row.push_back(inverse.at(row, k));
      }
      rotors_.push_back(std::move(rotor));
    }
    if (!is_given) require_hover(setup, robot, rotors);
  }

  /// Pseudo-inverse for rotors on the base, about the robot's centre of mass.
  static control::SixAxisInverse inverse_of(const Setup& setup, int robot,
                                            const View<RotorInfo>& rotors) {
    const Vec3<double> com = control::assembly_of(setup, robot).com;
    control::require_on_base(setup, robot, rotors,
                             ": give mixer the matrix `rotors`, or use `tilt_allocation`");
    control::SixAxisInverse inverse;
    for (const RotorInfo& rotor : rotors) {
      const control::RotorEffect effect = control::effect_about(rotor, com);
      inverse.add(control::vec3(rotor.axis_in_base), effect.torque);
    }
    inverse.invert("the rotors of robot `" + control::robot_name(setup, robot) + "`",
                   "mixer with `signal: wrench` needs: tilt their `axis`, or use `ctbt`");
    return inverse;
  }

  /// Throws if a rotor cannot give its hover thrust of the pseudo-inverse.
  void require_hover(const Setup& setup, int robot, const View<RotorInfo>& rotors) const {
    const double weight = control::total_mass(setup, robot) * control::gravity_of(setup);
    for (int i = 0; i < rotors.size(); ++i) {
      const Rotor& rotor = rotors_[static_cast<std::size_t>(i)];
      const double push = rotor.row[2] * weight, slack = 1e-9 * weight;
      if (push >= rotor.least - slack && push <= rotor.full + slack) continue;
      refuse("rotor `", rotors[i].name, "` would have to push ", push, " N to hover, and can push ",
             rotor.least, " to ", rotor.full,
             " N: give it a `min_speed` below 0 if it turns backwards, or mixer a matrix `rotors`");
    }
  }

  void take_servos(const Setup& setup, int robot) {
    const std::vector<std::string>& names = joints_.values();
    const int count = static_cast<int>(names.size());
    require_rows("servos", servo_matrix_, count, "joints");
    if (neutral_.count() != 0 && neutral_.count() != count) {
      refuse("`neutral` has ", neutral_.count(), " values, `joints` ", count,
             ": give one for each, or none");
    }
    for (int k = 0; k < count; ++k) {
      const std::string& name = names[static_cast<std::size_t>(k)];
      const control::DrivenJoint joint = control::driven_joint(setup, robot, name);
      for (const ServoRow& other : servos_) {
        if (other.joint.body != joint.body) continue;
        refuse("`joints` names `", name, "` twice: name each joint once");
      }
      servo_.declare(setup, joint, control::carried_inertia(setup.bodies()[joint.body], joint));
      servos_.push_back(
          {joint, row_of(servo_matrix_, k), neutral_.count() > 0 ? neutral_.value(k) : 0.0});
    }
  }

  /// Ranges of actions unless given: twice the weight for forces; for torques, the value at which a
  /// rotor or a joint reaches its limit.
  void declare_input(const Setup& setup, int robot) const {
    const double most = 2.0 * control::total_mass(setup, robot) * control::gravity_of(setup);
    std::vector<double> high;
    for (int k = 0; k < inputs_; ++k) {
      const int torque = takes_wrench_ ? k - 3 : k - 1;
      const double given = torque >= 0 ? max_torque_.value(torque) : max_thrust_.value();
      high.push_back(given > 0.0 ? given : torque >= 0 ? reach(k) : most);
      if (high.back() > 0.0) continue;
      refuse("no rotor answers to value ", k,
             " of the input, so that it has no range: give `max_thrust` and `max_torque` values "
             "above 0");
    }
    std::vector<double> low;
    for (const double h : high) low.push_back(-h);
    if (!takes_wrench_) low[0] = 0.0;
    setup.input(takes_wrench_ ? Signal::kWrench : Signal::kCtbt, low, high);
  }

  /// The value k of the input at which a rotor, or a servo from its neutral position, reaches its
  /// limit.
  double reach(int k) const {
    const auto place = static_cast<std::size_t>(k);
    double least = kInfinity;
    for (const Rotor& rotor : rotors_) {
      if (rotor.row[place] != 0.0) least = min(least, rotor.full / abs(rotor.row[place]));
    }
    for (const ServoRow& servo : servos_) {
      const double room = servo.joint.low < servo.joint.high ? min(servo.joint.high - servo.neutral,
                                                                   servo.neutral - servo.joint.low)
                                                             : kHalfPi;
      if (servo.row[place] != 0.0) least = min(least, room / abs(servo.row[place]));
    }
    return least < kInfinity ? least : 0.0;
  }

  TextParameter signal_{this, choice("signal", "ctbt", {"ctbt", "wrench"},
                                     "input: thrust along z and torque (4 values), or force and "
                                     "moment (6 values), axes of the base")};
  RealsParameter matrix_{this, list("rotors", "", {}, kAny,
                                    "matrix: thrust of each rotor [N] per value of the input, row "
                                    "by row; none, for `wrench` alone: the pseudo-inverse")};
  TextsParameter joints_{this, words("joints", "revolute and prismatic joints to drive")};
  RealsParameter servo_matrix_{
      this, list("servos", "", {}, kAny,
                 "matrix: position of each joint [rad] or [m] per value of the input, row by row")};
  RealsParameter neutral_{this, list("neutral", "rad or m", {}, kAny,
                                     "position of each joint for an input of 0; none: 0")};
  control::Servo servo_{this};
  RealParameter max_thrust_{this,
                            real("max_thrust", "N", 0.0, at_least(0.0),
                                 "thrust, or force, for action +1; 0: twice the robot's weight")};
  RealsParameter max_torque_{
      this,
      reals("max_torque", "N m", {0.0, 0.0, 0.0}, at_least(0.0),
            "torques for action +1; 0: the torque at which a rotor or a joint reaches its limit")};

  std::vector<Rotor> rotors_;
  std::vector<ServoRow> servos_;
  bool takes_wrench_ = false;
  int inputs_ = 4;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Mixer, "mixer", "1.0.0",
               "Maps thrust and torque, or a wrench, to rotors and servos by a matrix.");
