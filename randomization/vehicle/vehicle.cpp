// Draws whole quadrotors: a mass, and all other constants by scaling laws. Equations: README.md.
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "randomization/common/schedule.h"
#include "randomization/vehicle/laws.h"

namespace skybody {
namespace {

using namespace randomization;

class Vehicle : public Randomizer {
 public:
  template <class Real>
  using State = Schedule<Real>;

  Vehicle() {
    for (int k = 0; k < kVehicleQuantityCount; ++k) {
      const VehicleRow& row = kVehicleRows[k];
      given_[static_cast<std::size_t>(k)] =
          std::make_unique<RealsParameter>(this, RealsSpec{.name = row.name,
                                                           .unit = row.unit,
                                                           .count = -1,
                                                           .min = row.least,
                                                           .max = row.greatest,
                                                           .doc = row.doc});
    }
  }

  void configure(const Setup& setup) override {
    read_ranges();
    gravity_ = norm(Vec3<double>{setup.gravity()[0], setup.gravity()[1], setup.gravity()[2]});
    if (!(gravity_ > 0.0)) {
      refuse(
          "`gravity` is 0, so that `thrust_to_weight` has no weight: give the scenario a gravity");
    }
    const int only = robot_.value().empty() ? -1 : setup.robot(robot_.value());
    for (int r = 0; r < setup.robots().size(); ++r) {
      if (only < 0 || r == only) robots_.push_back(target(setup, r));
    }
  }

  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>& state, Start<Real>& start) const {
    const auto due = is_due(state, start.requested);
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      Real u[kVehicleQuantityCount];
      Random<Real> draw = numbers(env, 2 * i + (start.requested ? 1 : 0));
      for (Real& share : u) share = draw.uniform();
      build(u, robots_[i], due, start);
    }
    count_reset(state, start.requested, every_.value());
  }

 private:
  struct Hub {
    int first;       ///< first EnvParam of the rotor
    double x, y;     ///< relative to the centre, of length 1; body axes
    double height;   ///< above the centre, relative to the nominal arm
    double towards;  ///< +1 if a rotation towards the y axis is positive about z, else -1
  };
  struct Target {
    int body;             ///< first EnvParam of the base
    Vec3<double> middle;  ///< the centre of mass [m]
    std::vector<Hub> hubs;
  };
  /// ---- per episode

  /// Random numbers of one draw, or of one vehicle of the fleet, the same for all environments.
  template <class Real>
  SKYBODY_INLINE Random<Real> numbers(const EnvView<Real>& env, std::uint64_t substream) const {
    Random<Real> draw = random(env, substream);
    if (fleet_.value() == 0) return draw;
    const Real count = static_cast<double>(fleet_.value());
    const Word<Real> which = to_word(floor(draw.uniform() * count));
    return Random<Real>(env.seed(), which, Word<Real>(0), Word<Real>(0),
                        derive_stream("vehicle.fleet"));
  }

  template <class Real>
  SKYBODY_INLINE void build(const Real* u, const Target& target, const MaskOf<Real>& due,
                            Start<Real>& start) const {
    const auto at = [&](int k) SKYBODY_INLINE_LAMBDA {
      return laws_[static_cast<std::size_t>(k)].at(u[k]);
    };
    const auto put = [&](int param, const Real& value) SKYBODY_INLINE_LAMBDA {
      start.params.set(param, select(due, value, start.params[param]));
    };
    const Real mass = is_by_size_ ? cube(at(kMass)) : at(kMass);
    const Real log_mass = log(mass);
    const auto has = [&](int k)
                         SKYBODY_INLINE_LAMBDA { return is_used_[static_cast<std::size_t>(k)]; };
    const VehicleLaws<Real, decltype(at), decltype(has)> laws{at, has};
    VehicleRotors<Real> rotors;
    rotors.arm = exp(at(kArm) + log_mass * (1.0 / 3.0));
    rotors.sweep = at(kSweep);
    const Real ratio = at(kThrustToWeight);
    const Real full = ratio * mass * (0.25 * gravity_);  // of one rotor
    const Real about_x = laws.roll_inertia(mass, ratio, full, rotors.arm);
    put(target.body + SKYBODY_BODY_MASS, mass);
    put_inertia(about_x, at(kPitchInertia), at(kYawInertia), target, put);
    laws.make_rotors(exp(log_mass * tau_exponent_), full, ratio, rotors);
    for (const Hub& hub : target.hubs) put_rotor(rotors, hub, target.middle, put);
  }

  template <class Real>
  static SKYBODY_INLINE Real cube(const Real& x) {
    return x * x * x;
  }

  template <class Real, class Put>
  static SKYBODY_INLINE void put_inertia(const Real& about_x, const Real& pitch, const Real& yaw,
                                         const Target& target, const Put& put) {
    const Real about_y = pitch * about_x;
    const Real values[6] = {about_x,   about_y,   yaw * (about_x + about_y),
                            Real(0.0), Real(0.0), Real(0.0)};
    for (int k = 0; k < 6; ++k) put(target.body + SKYBODY_BODY_INERTIA + k, values[k]);
  }

  template <class Real, class Put>
  static SKYBODY_INLINE void put_rotor(const VehicleRotors<Real>& rotors, const Hub& hub,
                                       const Vec3<double>& middle, const Put& put) {
    for (int k = 0; k < SKYBODY_ROTOR_POSITION; ++k) put(hub.first + k, rotors.constants[k]);
    const SinCos<Real> turn = sincos(rotors.sweep);
    const Real sine = turn.sin * hub.towards;
    const int place = hub.first + SKYBODY_ROTOR_POSITION;
    put(place, middle.x + rotors.arm * (turn.cos * hub.x - sine * hub.y));
    put(place + 1, middle.y + rotors.arm * (turn.cos * hub.y + sine * hub.x));
    put(place + 2, middle.z + rotors.arm * hub.height);
  }

  /// ---- configuration

  static std::string text_of(const Range& range) {
    std::string text = "[";
    text.append(to_text(range.low)).append(", ").append(to_text(range.high)).append("]");
    return text;
  }
  static Range preset_range(const VehicleRow& row, const std::string& preset) {
    return preset == "scaling" ? row.scaling : preset == "l2f" ? row.l2f : row.raptor;
  }

  void read_ranges() {
    std::array<Range, kVehicleQuantityCount> ranges;
    for (int k = 0; k < kVehicleQuantityCount; ++k) {
      const auto i = static_cast<std::size_t>(k);
      ranges[i] = preset_range(kVehicleRows[k], preset_.value());
      if (given_[i]->count() > 0) ranges[i] = given_range(k);
    }
    choose({kGyration, kTorqueToInertia, kWeightByTurn}, ranges);
    choose({kMomentByRadius, kMomentArm}, ranges);
    choose({kTauDownByUp, kTauDown}, ranges);
    check_inertia(ranges);
    const bool is_scaling = preset_.value() == "scaling";
    const std::string &mass_by = mass_by_.value(), &tau_by = tau_by_.value();
    is_by_size_ = ranges[kMass].low < ranges[kMass].high &&
                  (mass_by == "preset" ? !is_scaling : mass_by == "size");
    tau_exponent_ = (tau_by == "preset" ? is_scaling : tau_by == "mass") ? 1.0 / 6.0 : 0.0;
    for (int k = 0; k < kVehicleQuantityCount; ++k) {
      const auto i = static_cast<std::size_t>(k);
      is_used_[i] = ranges[i].is_used();
      if (is_used_[i]) laws_[i] = law_of(k, ranges[i]);
    }
  }

  Range given_range(int k) const {
    const RealsParameter& given = *given_[static_cast<std::size_t>(k)];
    const std::string name = kVehicleRows[k].name;
    if (given.count() != 2) {
      refuse("`", name, "` has ", given.count(), " values: write [low, high]");
    }
    const Range range{given.value(0), given.value(1)};
    if (range.low > range.high) {
      refuse("`", name, "` ", text_of(range), " runs backwards: write [low, high]");
    }
    return range;
  }

  /// Among alternative quantities: the given one, or the preset's.
  void choose(std::initializer_list<int> alternatives,
              std::array<Range, kVehicleQuantityCount>& ranges) const {
    int chosen = -1;
    for (const int k : alternatives) {
      if (given_[static_cast<std::size_t>(k)]->count() == 0) continue;
      if (chosen >= 0) {
        refuse("`", kVehicleRows[chosen].name, "` and `", kVehicleRows[k].name,
               "` stand for one another: leave one of them out");
      }
      chosen = k;
    }
    if (chosen < 0) return;
    for (const int k : alternatives) {
      if (k != chosen) ranges[static_cast<std::size_t>(k)] = Range{};
    }
  }

  /// The largest moment of inertia about z is below the sum of the others by its range; these must
  /// be close enough as well.
  static void check_inertia(const std::array<Range, kVehicleQuantityCount>& ranges) {
    const Range &pitch = ranges[kPitchInertia], &yaw = ranges[kYawInertia];
    for (const double a : {pitch.low, pitch.high}) {
      if (std::abs(1.0 - a) <= yaw.low * (1.0 + a)) continue;
      refuse("`pitch_inertia` ", text_of(pitch), " and `yaw_inertia` ", text_of(yaw),
             " include moments of inertia that no rigid body has: bring `pitch_inertia` nearer to "
             "1, or raise `yaw_inertia`");
    }
  }

  Distribution law_of(int k, const Range& range) const {
    if (k == kArm) {
      const double low = log(range.low), high = log(range.high);
      if (low == high) return make_constant(low);
      return make_normal(0.5 * (low + high), 0.25 * (high - low), low, high);
    }
    if (range.low == range.high) return make_constant(range.low);
    if (k == kMass) {
      if (is_by_size_) return make_uniform(exp(log(range.low) / 3.0), exp(log(range.high) / 3.0));
      return make_log_uniform(range.low, range.high);
    }
    return make_uniform(range.low, range.high);
  }

  static Target target(const Setup& setup, int r) {
    const RobotInfo& robot = setup.robots()[r];
    const std::string name = "robot `" + std::string(robot.name) + "` ";
    const View<RotorInfo> rotors = setup.rotors_of(r);
    if (robot.body_count != 1 || robot.fixed_base != 0) {
      refuse(name, (robot.fixed_base != 0 ? "has a fixed base" : "has joints"),
             ": a vehicle is one free body; name another robot in `robot`");
    }
    if (rotors.size() != 4) {
      refuse(name, "has ", rotors.size(),
             " rotors: a vehicle has 4; name another robot in `robot`");
    }
    const BodyInfo& base = setup.bodies()[robot.first_body];
    Target t{base.first_param, {base.com[0], base.com[1], base.com[2]}, {}};
    double turns = 0.0;
    for (const RotorInfo& rotor : rotors) {
      t.hubs.push_back(hub(rotor, t.middle, name));
      turns += rotor.direction;
      for (int k = 0; k < SKYBODY_ROTOR_CONSTANT_COUNT; ++k) setup.writes(rotor.first_param + k);
    }
    if (turns != 0.0) {
      refuse(name,
             "has more rotors of one sense than of the other, and would turn: let two be ccw and "
             "two cw");
    }
    setup.writes(t.body + SKYBODY_BODY_MASS);
    for (int k = 0; k < 6; ++k) setup.writes(t.body + SKYBODY_BODY_INERTIA + k);
    return t;
  }

  static Hub hub(const RotorInfo& rotor, const Vec3<double>& middle, const std::string& robot) {
    const double *p = rotor.position, *n = rotor.axis;
    const Vec3<double> from{p[0] - middle.x, p[1] - middle.y, p[2] - middle.z};
    const double arm = sqrt(from.x * from.x + from.y * from.y);
    const std::string name = "rotor `" + std::string(rotor.name) + "` of " + robot;
    if (n[0] != 0.0 || n[1] != 0.0 || n[2] != 1.0) {
      refuse(
          name,
          "does not push along the body's z, as a vehicle's rotors do: give it `axis: [0, 0, 1]`");
    }
    if (!(arm > 1e-6)) {
      refuse(name, "sits on the body's z axis, so that its arm has no direction: move it aside");
    }
    return {rotor.first_param, from.x / arm, from.y / arm, from.z / arm,
            from.x * from.y >= 0.0 ? 1.0 : -1.0};
  }

  TextParameter robot_{
      this, word("robot", "", "name of the robot; empty: every robot, each its own vehicle")};
  TextParameter preset_{this, choice("preset", "scaling", {"scaling", "l2f", "raptor"},
                                     "ranges of the quantities not given")};
  TextParameter mass_by_{this, choice("mass_by", "preset", {"preset", "logarithm", "size"},
                                      "the mass is uniform in its logarithm (preset scaling) or in "
                                      "its cube root (the others)")};
  TextParameter tau_by_{this, choice("tau_by", "preset", {"preset", "mass", "itself"},
                                     "mass: time constants grow with the mass's sixth root (preset "
                                     "scaling); itself: they do not (the others)")};
  IntegerParameter every_{this, every_spec()};
  IntegerParameter fleet_{this,
                          integer("fleet", "", 0, between(0, 1000000000),
                                  "number of vehicles, the same for all environments of a seed, "
                                  "one of which is drawn; 0: each draw is another vehicle")};
  std::array<std::unique_ptr<RealsParameter>, kVehicleQuantityCount> given_;

  std::array<Distribution, kVehicleQuantityCount> laws_;
  std::array<bool, kVehicleQuantityCount> is_used_{};
  bool is_by_size_ = false;  ///< the mass is the cube of the drawn value
  double tau_exponent_ = 0.0;
  double gravity_ = 0.0;  ///< nominal [m/s^2]
  std::vector<Target> robots_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Vehicle, "vehicle", "1.0.0",
               "Draws whole quadrotors of any size by scaling laws.");
