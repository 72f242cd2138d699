// Downwash: air jets below rotors push bodies of other robots down.
//
// Each body with rotors has one jet, from the mean of its hubs along the rotors' axes. All
// combinations of jets and bodies are evaluated, N^2 for N robots, so each is cheap: a vector, its
// components along and across the jet, and the exponential only if a lane is inside the jet.
#include <skybody/plugin.h>

#include <vector>

#include "effects/common/hubs.h"
#include "effects/common/rotors.h"

namespace skybody {
namespace {

class Downwash : public Effect {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    is_gzdrl_ = form_.value() == "gzdrl";
    check_form();
    const std::vector<int> own = own_bodies(setup);
    for (const effect::Carrier& carrier : effect::carriers_of(
             setup, effect::robots_with_one_way_rotors(setup, robots_.values(), "downwash"))) {
      jets_.push_back(jet_of(setup, carrier));
      add_targets(setup, own, jets_.back());
    }
    for (const Jet& jet : jets_) {
      if (!jet.targets.empty()) return setup.holds(HeldInput::kWrench);
    }
    refuse(
        "there is nothing that downwash could push: add a robot, name links in `own_links`, or "
        "leave the effect out");
  }

  /// Forces at the present poses, constant over the step.
  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>&, Held<Real>& held) const {
    const Shape<Real> shape = this->shape(env);
    for (const Jet& jet : jets_) {
      const BodyMotion<Real> body = env.body(jet.body);
      const Vec3<Real> from = body.position + rotate(body.rotation, to_real<Real>(jet.origin));
      const Vec3<Real> axis = rotate(body.rotation, to_real<Real>(jet.axis));
      const Real strength = this->strength(env, jet);
      for (const int target : jet.targets) {
        const Vec3<Real> way = env.body(target).position - from;
        push(shape, strength, way, axis, target, held);
      }
    }
  }

 private:
  static constexpr double kTiny = 1e-12;     ///< [m^2], prevents division by 0
  static constexpr double kFarthest = 40.0;  ///< in exp(-x): beyond it, 4e-18 of the central force

  /// The jet of one body's rotors.
  struct Jet {
    int robot = 0, body = 0;
    Vec3<double> origin, axis;  ///< mean of the hubs [m], direction of thrust; body axes
    std::vector<effect::Hub> rotors;
    double weight = 0.0;       ///< of the whole robot, nominal [N]
    double share = 1.0;        ///< share of the robot's thrust constants
    std::vector<int> targets;  ///< bodies that it can push
  };
  /// The parameters of one environment.
  template <class Real>
  struct Shape {
    Real peak;           ///< [N]; times the squared distance, if the jet decays along its axis
    Real spread, start;  ///< width over distance, width at distance 0
    Real least, reach;   ///< limits of distances [m]
  };

  void check_form() const {
    const auto demand = [&](const RealParameter& parameter, const char* name, const char* unit) {
      if (parameter.value() > 0.0) return;
      refuse("`", name, "` is 0, but `form: ", form_.value(),
             "` needs it: allowed are values above 0 ", unit);
    };
    if (is_gzdrl_) {
      demand(force_, "force", "N");
      if (spread_.value() == 0.0 && start_.value() == 0.0) {
        refuse("`spread` and `start` are both 0, so the jet has no width: raise one of them");
      }
    } else {
      demand(radius_, "radius", "m");
    }
  }

  /// The bodies of `own_links`.
  std::vector<int> own_bodies(const Setup& setup) const {
    std::vector<int> bodies;
    for (const std::string& name : own_links_.values()) {
      const std::size_t dot = name.find('.');
      if (dot == std::string::npos) {
        refuse("`own_links` has `", name,
               "`: allowed are names as ROBOT.LINK, such as quad.payload");
      }
      bodies.push_back(setup.link(setup.robot(name.substr(0, dot)), name.substr(dot + 1)).body);
    }
    return bodies;
  }

  /// From the mean of the hubs along the mean axis, weighted by the nominal thrust constants.
  Jet jet_of(const Setup& setup, const effect::Carrier& carrier) const {
    const RobotInfo& robot = setup.robots()[carrier.robot];
    Jet jet;
    jet.robot = carrier.robot;
    jet.body = carrier.body;
    jet.rotors = carrier.hubs;
    Vec3<double> place{}, axis{};
    double all = 0.0, here = 0.0, mass = 0.0;
    for (const RotorInfo& rotor : setup.rotors_of(carrier.robot)) {
      all += rotor.constants[SKYBODY_ROTOR_THRUST_CONSTANT];
    }
    for (const effect::Hub& hub : carrier.hubs) {
      const double k = setup.rotors()[hub.rotor].constants[SKYBODY_ROTOR_THRUST_CONSTANT];
      here += k;
      place += hub.position * k;
      axis += hub.axis * k;
    }
    if (norm(axis) < 1e-6 * here) {
      refuse("the rotors of robot `", robot.name,
             "` push against one another, so that their jet has no direction: leave the robot out "
             "of `robots`");
    }
    for (int b = 0; b < robot.body_count; ++b) mass += setup.bodies()[robot.first_body + b].mass;
    const double* g = setup.gravity();
    jet.origin = place / here;
    jet.axis = axis / norm(axis);
    jet.weight = mass * norm(Vec3<double>{g[0], g[1], g[2]});
    jet.share = here / all;
    if (by_thrust_.value() && jet.weight == 0.0) {
      refuse(
          "`by_thrust` compares with the thrust in hover, which is 0 without gravity: set it to "
          "false");
    }
    return jet;
  }

  static void add_targets(const Setup& setup, const std::vector<int>& own, Jet& jet) {
    for (int b = 0; b < setup.bodies().size(); ++b) {
      bool is_target = setup.bodies()[b].robot != jet.robot;
      for (const int body : own) is_target = is_target || body == b;
      if (is_target && b != jet.body) jet.targets.push_back(b);
    }
  }

  template <class Real>
  SKYBODY_INLINE Shape<Real> shape(const EnvView<Real>& env) const {
    if (is_gzdrl_) {
      return {force_(env), spread_(env), start_(env), Real(0.0), reach_(env)};
    }
    const Real quarter = 0.25 * radius_(env);
    return {k1_(env) * (quarter * quarter), k2_(env), k3_(env), least_distance_(env), reach_(env)};
  }

  /// Thrust of a jet, in units of the robot's hover thrust.
  template <class Real>
  SKYBODY_INLINE Real strength(const EnvView<Real>& env, const Jet& jet) const {
    if (!by_thrust_.value()) return Real(jet.share);
    Real thrust(0.0);
    for (const effect::Hub& hub : jet.rotors) {
      const Real w = env.rotor_speed(hub.rotor);
      thrust += env.param(hub.thrust_constant) * (w * w);
    }
    return thrust / jet.weight;
  }

  /// The force of one jet on one body.
  /// @param way  from the jet's origin to the body, W [m]
  template <class Real>
  SKYBODY_INLINE void push(const Shape<Real>& shape, const Real& strength, const Vec3<Real>& way,
                           const Vec3<Real>& axis, int target, Held<Real>& held) const {
    const Real below = -dot(way, axis);
    const Real off = squared_norm(way + axis * below);
    const Real width = shape.spread * below + shape.start;
    Real exponent;
    if (is_gzdrl_) {
      const Real ratio = off / max(width, Real(kTiny));
      exponent = 0.5 * (ratio * ratio);
    } else {
      exponent = 0.5 * (off / max(width * width, Real(kTiny)));
    }
    const auto is_hit =
        logical_and(logical_and(below > 0.0, below < shape.reach), exponent < kFarthest);
    if (none(is_hit)) return;
    Real force = (shape.peak * strength) * exp(-exponent);
    if (!is_gzdrl_) {
      const Real distance = max(below, shape.least);
      force = force / (distance * distance);
    }
    const Vec3<Real> no_moment{Real(0.0), Real(0.0), Real(0.0)};
    held.add_wrench(target, axis * select(is_hit, -force, Real(0.0)), no_moment);
  }

  TextsParameter robots_{this, words("robots", "robots whose rotors blow; empty: all with rotors")};
  TextsParameter own_links_{
      this, words("own_links",
                  "links, as ROBOT.LINK, pushed by jets of their own robot as well: payloads")};
  TextParameter form_{this, choice("form", "gym_pybullet_drones", {"gym_pybullet_drones", "gzdrl"},
                                   "equation of the force")};
  BooleanParameter by_thrust_{this, boolean("by_thrust", true,
                                            "the force is proportional to the upper robot's thrust "
                                            "over its weight; false: it is constant")};
  RealParameter reach_{
      this, randomizable(real("reach", "m", 10.0, between(0.01, 1000.0), "length of the jet"))};
  RealParameter radius_{
      this, randomizable(real("radius", "m", 0.0, between(0.0, 100.0),
                              "radius R of a rotor; above 0 with form gym_pybullet_drones"))};
  RealParameter k1_{this, randomizable(real("k1", "N", 2267.18, between(0.0, 1e9),
                                            "gym_pybullet_drones: force at the distance R/4"))};
  RealParameter k2_{this,
                    randomizable(real("k2", "", 0.16, between(-100.0, 100.0),
                                      "gym_pybullet_drones: growth of the width per distance"))};
  RealParameter k3_{this, randomizable(real("k3", "m", -0.11, between(-100.0, 100.0),
                                            "gym_pybullet_drones: width at distance 0"))};
  RealParameter least_distance_{
      this, randomizable(
                real("least_distance", "m", 0.5, between(0.001, 1000.0),
                     "gym_pybullet_drones: distance below which the central force is constant"))};
  RealParameter force_{this, randomizable(real("force", "N", 0.0, between(0.0, 1e6),
                                               "gzdrl: force at the jet's axis; must be above 0"))};
  RealParameter spread_{
      this, randomizable(real("spread", "m", 0.0, between(0.0, 1e6),
                              "gzdrl: growth of the jet's squared radius per distance"))};
  RealParameter start_{this, randomizable(real("start", "m^2", 0.0, between(0.0, 1e6),
                                               "gzdrl: the jet's squared radius at distance 0"))};

  std::vector<Jet> jets_;
  bool is_gzdrl_ = false;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Downwash, "downwash", "1.0.0",
               "Jets below rotors that push bodies of other robots down.");
