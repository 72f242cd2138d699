// Thrust curve: thrust and reaction moment as polynomials of a rotor's speed, and their loss with
// its axial velocity through the air.
#include <algorithm>
#include <vector>

#include "effects/common/rotors.h"

namespace skybody {
namespace {

class ThrustCurve : public Effect {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    check_parameters();
    for (const int robot :
         effect::robots_with_one_way_rotors(setup, robots_.values(), "`thrust_curve`")) {
      for (const RotorInfo& rotor : setup.rotors_of(robot)) add_rotor(setup, rotor);
      check_thrust(setup, robot);
    }
    advances_ = thrust_by_advance_.count() > 0 || moment_by_advance_.count() > 0;
    setup.holds(HeldInput::kRotorGain);
  }

  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>&, Held<Real>& held) const {
    for (const Rotor& rotor : rotors_) {
      // Below the least speed the gains are constant, because w^2 tends to 0.
      const Real speed = max(env.rotor_speed(rotor.index), rotor.least_speed);
      Real thrust = curve_gain(thrust_, rotor.per_thrust, speed);
      Real moment = curve_gain(moment_, rotor.per_moment, speed);
      if (advances_) {
        const Real advance = advance_ratio(env, rotor, speed);
        thrust = thrust * ratio(thrust_by_advance_, advance);
        moment = moment * ratio(moment_by_advance_, advance);
      }
      held.scale_thrust(rotor.index, thrust);
      held.scale_moment(rotor.index, moment);
    }
  }

 private:
  struct Rotor {
    int index, body;                ///< world indices
    int place;                      ///< EnvParam of the hub's x; y and z follow
    Vec3<double> axis;              ///< in the body's frame
    double per_thrust, per_moment;  ///< 1 / k_f and 1 / k_m, nominal
    double least_speed;             ///< [rad/s]
  };

  /// The polynomial relative to the constant's parabola: sum of c_k w^k, over k w^2; 1 without a
  /// polynomial.
  template <class Real>
  static SKYBODY_INLINE Real curve_gain(const RealsParameter& coefficients, double per_constant,
                                        const Real& speed) {
    if (coefficients.count() == 0) return Real(1.0);
    Real sum(0.0);
    for (int k = coefficients.count() - 1; k >= 0; --k) sum = sum * speed + coefficients.value(k);
    return sum * per_constant / (speed * speed);
  }

  /// 1 + a_1 J + a_2 J^2 + ...
  template <class Real>
  static SKYBODY_INLINE Real ratio(const RealsParameter& coefficients, const Real& advance) {
    Real sum(0.0);
    for (int k = coefficients.count() - 1; k >= 0; --k) {
      sum = (sum + coefficients.value(k)) * advance;
    }
    return sum + 1.0;
  }

  /// J = v_axial / (n D), n in revolutions per second, clamped to its range.
  template <class Real>
  SKYBODY_INLINE Real advance_ratio(const EnvView<Real>& env, const Rotor& rotor,
                                    const Real& speed) const {
    const BodyMotion<Real> body = env.body(rotor.body);
    const Vec3<Real> position = env.param_vec3(rotor.place), axis = lift<Real>(rotor.axis);
    const Vec3<Real> hub =
        rotate_inverse(body.rotation, body.velocity) + cross(body.angular_velocity, position);
    const Real advance = dot(hub, axis) * (kTwoPi / diameter_.value()) / speed;
    return clamp(advance, least_advance_.value(), greatest_advance_.value());
  }

  template <class Real>
  static SKYBODY_INLINE Vec3<Real> lift(const Vec3<double>& v) {
    return {Real(v.x), Real(v.y), Real(v.z)};
  }

  void add_rotor(const Setup& setup, const RotorInfo& rotor) {
    const double* constants = rotor.constants;
    const double moment = constants[SKYBODY_ROTOR_MOMENT_CONSTANT];
    if (moment_.count() > 0 && !(moment > 0.0)) {
      refuse("rotor `", rotor.name,
             "` has a `moment_constant` of 0, which no factor turns into `moment`: give it one "
             "above 0 in the robot's rotors file");
    }
    rotors_.push_back({static_cast<int>(&rotor - setup.rotors().begin()),
                       rotor.body,
                       rotor.first_param + SKYBODY_ROTOR_POSITION,
                       {rotor.axis[0], rotor.axis[1], rotor.axis[2]},
                       1.0 / constants[SKYBODY_ROTOR_THRUST_CONSTANT],
                       moment > 0.0 ? 1.0 / moment : 0.0,
                       least_share_.value() * constants[SKYBODY_ROTOR_MAX_SPEED]});
  }

  /// c_0 + c_1 w + c_2 w^2 + ...
  static double polynomial(const RealsParameter& coefficients, double speed) {
    double sum = 0.0;
    for (int k = coefficients.count() - 1; k >= 0; --k) sum = sum * speed + coefficients.value(k);
    return sum;
  }

  /// Rejects a curve whose rotors cannot carry the robot at `max_speed`: usually wrong signs or
  /// units (revolutions per minute). Also rejects a moment that drives the rotor.
  void check_thrust(const Setup& setup, int robot) const {
    double most = 0.0;
    for (const RotorInfo& rotor : setup.rotors_of(robot)) {
      const double speed = rotor.constants[SKYBODY_ROTOR_MAX_SPEED];
      const double thrust = polynomial(thrust_, speed), moment = polynomial(moment_, speed);
      const std::string at = " at the `max_speed` of rotor `" + std::string(rotor.name) + "`, " +
                             to_text(speed) + " rad/s: allowed are values above 0";
      if (thrust_.count() > 0 && !(thrust > 0.0)) {
        refuse("`thrust` is ", thrust, " N", at);
      }
      if (moment_.count() > 0 && moment < 0.0) {
        refuse("`moment` is ", moment, " N m", at, " and 0");
      }
      most += thrust;
    }
    const double weight = effect::weight(setup, robot);
    if (thrust_.count() == 0 || most > weight) return;
    refuse("by `thrust` all rotors of robot `", setup.robots()[robot].name, "` give ", most,
           " N at `max_speed`, and it weighs ", weight,
           " N: give coefficients in N (s/rad)^k that carry it");
  }

  void check_parameters() const {
    const bool has_advance = thrust_by_advance_.count() > 0 || moment_by_advance_.count() > 0;
    if (!has_advance && thrust_.count() == 0 && moment_.count() == 0) {
      refuse(
          "`thrust`, `moment`, `thrust_by_advance` and `moment_by_advance` are all empty: give one "
          "of them coefficients, or leave the effect out");
    }
    if (has_advance && !(diameter_.value() > 0.0)) {
      refuse("`diameter` is 0, but the advance ratio is v / (n D): give the rotors' diameter in m");
    }
    if (least_advance_.value() > 0.0 || greatest_advance_.value() < 0.0) {
      refuse("`least_advance` ", least_advance_.value(), " and `greatest_advance` ",
             greatest_advance_.value(),
             " leave out 0, where rotors hover: lower the first or raise the second");
    }
  }

  TextsParameter robots_{
      this, words("robots", "robots with these rotors, all alike; empty: all with rotors")};
  RealsParameter thrust_{
      this,
      list("thrust", "N (s/rad)^k", {}, kAny,
           "coefficients k = 0, 1, ... of the thrust's polynomial in the speed; empty: k_f w^2")};
  RealsParameter moment_{
      this, list("moment", "N m (s/rad)^k", {}, kAny,
                 "coefficients of the reaction moment's polynomial in the speed; empty: k_m w^2")};
  RealsParameter thrust_by_advance_{
      this, list("thrust_by_advance", "", {}, kAny,
                 "a_1, a_2, ... of C_T(J) / C_T(0) = 1 + a_1 J + a_2 J^2 + ...; empty: 1")};
  RealsParameter moment_by_advance_{
      this, list("moment_by_advance", "", {}, kAny, "the same for C_Q(J) / C_Q(0)")};
  RealParameter diameter_{this, real("diameter", "m", 0.0, between(0.0, 100.0),
                                     "diameter D of the rotors; needed with the advance ratio")};
  RealParameter least_advance_{
      this, real("least_advance", "", 0.0, between(-100.0, 100.0),
                 "lower limit of the advance ratio's polynomials; J is clamped to it")};
  RealParameter greatest_advance_{
      this, real("greatest_advance", "", 1.0, between(-100.0, 100.0),
                 "upper limit of the advance ratio's polynomials; J is clamped to it")};
  RealParameter least_share_{
      this, real("least_share", "", 0.05, between(1e-3, 1.0),
                 "share of `max_speed`: slower rotors have the factors of this speed")};

  bool advances_ = false;
  std::vector<Rotor> rotors_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::ThrustCurve, "thrust_curve", "1.0.0",
               "Thrust [N] and moment [N m] by polynomials of speed and advance ratio.");
