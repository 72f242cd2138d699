// Initial states of robots: position, heading, tilt, velocity, rates, rotor speeds.
#include <skybody/plugin.h>

#include <cmath>
#include <vector>

namespace skybody {
namespace {

class RandomStart : public Randomizer {
 public:
  void configure(const Setup& setup) override {
    check_ranges();
    gravity_ = setup.find_params("gravity")[0];
    const int only = robot_.value().empty() ? -1 : setup.robot(robot_.value());
    for (int r = 0; r < setup.robots().size(); ++r) {
      const RobotInfo& info = setup.robots()[r];
      if (only >= 0 && r != only) continue;
      if (info.fixed_base != 0) {
        if (only < 0) continue;
        refuse("robot `", info.name,
               "` has a fixed base, which cannot start elsewhere: name another robot, or leave "
               "`start` out");
      }
      robots_.push_back(target(setup, info));
    }
    if (robots_.empty()) {
      refuse("no robot has a floating base: leave `start` out");
    }
    if (together_.value() && moves_ && !relative_.value() && robots_.size() > 1) {
      refuse(
          "`together` without `relative` would put all robots in one place: set `relative: true`, "
          "so that the draw is added to each robot's own pose");
    }
  }

  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>&, Start<Real>& start) const {
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      place(random(env, together_.value() ? 0 : i), robots_[i], start);
      if (hover_.value() == "hover") spin(env, robots_[i], start);
    }
  }

 private:
  /// First EnvParams.
  struct Rotor {
    int start;  ///< its initial speed
    int constants;
    double lift;       ///< axis . z of the base; negative: it lifts in reverse rotation
    double min_speed;  ///< [rad/s]
  };
  struct Target {
    int position_param, rotation_param, velocity, angular_velocity;  ///< first EnvParams
    Vec3<double> position;                                           ///< the scenario's
    Quat<double> rotation;
    std::vector<int> masses;  ///< EnvParams
    std::vector<Rotor> rotors;
  };

  static void require_order(const std::string& low_name, double low, const std::string& high_name,
                            double high) {
    if (low <= high) return;
    refuse("`", low_name, "` ", low, " is above `", high_name, "` ", high, ": swap them");
  }

  void check_ranges() {
    require_order("yaw_min", yaw_min_.value(), "yaw_max", yaw_max_.value());
    const int low = position_min_.count(), high = position_max_.count();
    if (low != high || (low != 0 && low != 3)) {
      refuse("`position_min` has ", low, " values and `position_max` ", high,
             ": give both [x, y, z], or neither to keep the scenario's position");
    }
    moves_ = low == 3;
    for (int k = 0; k < low; ++k) {
      const std::string place = "[" + std::to_string(k) + "]";
      require_order("position_min" + place, position_min_.value(k), "position_max" + place,
                    position_max_.value(k));
    }
    if (moves_) {
      low_ = position_min_.vec3();
      high_ = position_max_.vec3();
    }
  }

  Target target(const Setup& setup, const RobotInfo& info) const {
    const std::string path = "robots." + std::string(info.name) + ".start.";
    const auto announce = [&](const std::string& name) {
      const std::vector<int> params = setup.find_params(path + name);
      for (const int param : params) setup.writes(param);
      return params[0];
    };
    Target t{announce("position"),
             announce("rotation"),
             announce("velocity"),
             announce("angular_velocity"),
             {info.position[0], info.position[1], info.position[2]},
             {info.rotation[0], info.rotation[1], info.rotation[2], info.rotation[3]},
             {},
             {}};
    for (int b = 0; b < info.body_count; ++b) {
      t.masses.push_back(setup.bodies()[info.first_body + b].first_param + SKYBODY_BODY_MASS);
    }
    if (hover_.value() == "keep") return t;
    double lift = 0.0;
    for (int k = 0; k < info.rotor_count; ++k) {
      const RotorInfo& rotor = setup.rotors()[info.first_rotor + k];
      const int start = announce("rotors[" + std::to_string(k) + "].speed");
      constexpr double kLeastLift = 1e-6;  // below it is rounding
      const double up = rotor.axis_in_base[2];
      const bool lifts = up > kLeastLift || (rotor.min_speed < 0.0 && up < -kLeastLift);
      t.rotors.push_back({start, rotor.first_param, lifts ? up : 0.0, rotor.min_speed});
      lift += std::fabs(t.rotors.back().lift);
    }
    if (!(lift > 1e-6)) {
      refuse("robot `", info.name,
             "` has no rotor that lifts, so that there is no hover speed: set `rotor_speed: keep`");
    }
    return t;
  }

  /// Uniform numbers of one robot's draw, in this order.
  enum Draw {
    kX,
    kY,
    kZ,
    kYaw,
    kTilt,
    kAxis,
    kVelocity,
    kRate = kVelocity + 3,
    kDraws = kRate + 3
  };

  template <class Real>
  SKYBODY_INLINE void place(Random<Real> draw, const Target& t, Start<Real>& start) const {
    Real draws[kDraws];
    for (Real& d : draws) d = draw.uniform();
    const Vec3<double> span = high_ - low_;
    const Vec3<double> from =
        low_ + (relative_.value() || !moves_ ? t.position : Vec3<double>{0.0, 0.0, 0.0});
    start.params.set(t.position_param,
                     Vec3<Real>{from.x + span.x * draws[kX], from.y + span.y * draws[kY],
                                max(from.z + span.z * draws[kZ], min_height_.value())});
    start.params.set(t.rotation_param, rotation(draws, t));
    start.params.set(t.velocity, random_vector(draws + kVelocity, velocity_max_.value()));
    start.params.set(t.angular_velocity, random_vector(draws + kRate, rate_max_.value()));
  }

  /// Tilt about a random horizontal axis, then heading; added to the scenario's own if relative.
  template <class Real>
  SKYBODY_INLINE Quat<Real> rotation(const Real* draws, const Target& t) const {
    const Real turn = yaw_min_.value() + (yaw_max_.value() - yaw_min_.value()) * draws[kYaw];
    const SinCos<Real> axis = sincos(kTwoPi * draws[kAxis]);
    const Quat<Real> tilt = from_axis_angle(Vec3<Real>{axis.cos, axis.sin, Real(0.0)},
                                            tilt_max_.value() * draws[kTilt]);
    const Quat<Real> heading = from_axis_angle(Vec3<Real>{Real(0.0), Real(0.0), Real(1.0)}, turn);
    const Quat<Real> own = relative_.value() ? Quat<Real>{Real(t.rotation.w), Real(t.rotation.x),
                                                          Real(t.rotation.y), Real(t.rotation.z)}
                                             : Quat<Real>::identity();
    return normalized(heading * tilt * own);
  }

  /// Random direction, magnitude uniform up to `largest`. Uses three draws; z is uniform
  /// (Archimedes).
  template <class Real>
  static SKYBODY_INLINE Vec3<Real> random_vector(const Real* draws, double largest) {
    const Real z = 2.0 * draws[0] - 1.0;
    const SinCos<Real> angle = sincos(kTwoPi * draws[1]);
    const Real side = sqrt((1.0 - z) * (1.0 + z));
    return Vec3<Real>{side * angle.cos, side * angle.sin, z} * (largest * draws[2]);
  }

  /// Equal speed of all rotors that carries the environment's own weight, level.
  template <class Real>
  SKYBODY_INLINE void spin(const EnvView<Real>& env, const Target& t, Start<Real>& start) const {
    Real mass(0.0), lift(0.0);
    for (const int param : t.masses) mass += env.param(param);
    for (const Rotor& r : t.rotors)
      lift += env.param(r.constants + SKYBODY_ROTOR_THRUST_CONSTANT) * std::fabs(r.lift);
    const Vec3<Real> gravity{env.param(gravity_), env.param(gravity_ + 1), env.param(gravity_ + 2)};
    const Real speed = sqrt(mass * norm(gravity) / lift);
    for (const Rotor& r : t.rotors) {
      const Real own = r.lift > 0.0   ? speed
                       : r.lift < 0.0 ? max(Real(0.0) - speed, Real(r.min_speed))
                                      : Real(0.0);
      start.params.set(r.start, min(own, env.param(r.constants + SKYBODY_ROTOR_MAX_SPEED)));
    }
  }

  TextParameter robot_{this,
                       word("robot", "", "name of the robot; empty: every robot with a free base")};
  BooleanParameter relative_{
      this,
      boolean(
          "relative", false,
          "true: position, yaw and tilt are added to the scenario's pose; false: they replace it")};
  BooleanParameter together_{
      this,
      boolean("together", false, "true: every robot gets the same draw; false: each its own")};
  RealsParameter position_min_{
      this, list("position_min", "m", {}, kAny,
                 "lower corner of the box of positions (W axes); none: the scenario's position")};
  RealsParameter position_max_{
      this, list("position_max", "m", {}, kAny, "upper corner of the box of positions (W axes)")};
  RealParameter min_height_{
      this, real("min_height", "m", 0.0, kAny, "least initial height of the base (W z)")};
  RealParameter yaw_min_{this, real("yaw_min", "rad", 0.0, kAny, "smallest random heading")};
  RealParameter yaw_max_{this, real("yaw_max", "rad", 0.0, kAny, "largest random heading")};
  RealParameter tilt_max_{this, real("tilt_max", "rad", 0.0, between(0.0, kPi),
                                     "largest tilt, about a random horizontal axis")};
  RealParameter velocity_max_{
      this, real("velocity_max", "m/s", 0.0, at_least(0.0), "largest velocity, in any direction")};
  RealParameter rate_max_{this, real("rate_max", "rad/s", 0.0, at_least(0.0),
                                     "largest angular velocity, about any axis")};
  TextParameter hover_{
      this, choice("rotor_speed", "keep", {"keep", "hover"},
                   "keep: the scenario's; hover: the speed that carries the random weight")};

  std::vector<Target> robots_;
  Vec3<double> low_{0.0, 0.0, 0.0}, high_{0.0, 0.0, 0.0};  ///< box of positions [m]
  bool moves_ = false;
  int gravity_ = 0;  ///< first EnvParam
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::RandomStart, "start", "1.0.0",
               "Draws pose, velocity and rotor speeds at a reset.");
