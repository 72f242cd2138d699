// Wind: a constant air velocity, and 1-cosine gusts at random times; both uniform, or with a
// boundary-layer profile above the ground.
#include <skybody/plugin.h>

#include <vector>

#include "effects/common/robots.h"

namespace skybody {
namespace {

class Wind : public Effect {
 public:
  static constexpr bool kSmooth = true;

  template <class Real>
  struct State {
    Real begin;            ///< start of the present or the next gust [s]
    Vec3<Real> direction;  ///< of that gust, unit, W
  };

  void configure(const Setup& setup) override {
    dt_ = setup.dt();
    bodies_ = effect::bodies_of(setup, effect::robots_called(setup, robots_.values()));
    choose_direction();
    choose_profile();
    const double longest = static_cast<double>(period_.value()) * dt_;
    if (gust_speed_.value() > 0.0 && gust_duration_.value() < 2.0 * longest) {
      refuse("`gust_duration` is ", gust_duration_.value(), " s, but the effect is called every ",
             longest, " s: allowed are at least two calls a gust; lower `period`");
    }
    setup.holds(HeldInput::kWind);
    setup.period(static_cast<int>(period_.value()));
  }

  /// The first gust of the episode.
  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state) const {
    Random<Real> draw = random(env, kResetDraws);
    state.begin = wait(draw);
    state.direction = direction(draw);
  }

  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>& state, Held<Real>& held) const {
    const Real time = to_real(env.physics_step()) * dt_;
    const Vec3<Real> wind = velocity_.vec3(env) + gust(env, time, state);
    for (const int body : bodies_) {
      held.add_wind(body, profile_ == Profile::kUniform ? wind : wind * share_at(env, body));
    }
  }

 private:
  static constexpr std::uint64_t kApplyDraws = 0, kResetDraws = 1;
  /// [m]; below every `reference_height` of a logarithmic profile, including randomized ones.
  static constexpr double kRoughest = 1.0;
  enum class Profile { kUniform, kPower, kLogarithmic };

  void choose_direction() {
    if (gust_direction_.count() == 0) return;
    if (gust_direction_.count() != 3 || norm(gust_direction_.vec3()) == 0.0) {
      refuse(
          "`gust_direction` is a vector of three values, not all of them 0; without it every gust "
          "has a heading of its own");
    }
    fixed_direction_ = gust_direction_.vec3() / norm(gust_direction_.vec3());
  }

  void choose_profile() {
    const std::string& name = profile_name_.value();
    if (name == "power") profile_ = Profile::kPower;
    if (name == "logarithmic") profile_ = Profile::kLogarithmic;
    if (profile_ == Profile::kLogarithmic && reference_height_.value() <= kRoughest) {
      refuse("`reference_height` is ", reference_height_.value(),
             " m; with `profile: logarithmic` it must be more than 1 m, which is the greatest "
             "`roughness`: give the speed at a greater height");
    }
  }

  /// Wind at a body's height, from the wind at `reference_height`.
  template <class Real>
  SKYBODY_INLINE Real share_at(const EnvView<Real>& env, int body) const {
    const Real height = max(env.body(body).position.z, least_height_.value());
    const double reference = reference_height_.value();
    if (profile_ == Profile::kPower) return exp(exponent_(env) * log(height / reference));
    const Real roughness = roughness_(env);
    return log(max(height, roughness) / roughness) / log(reference / roughness);
  }

  /// Time from the end of a gust to the next one.
  template <class Real>
  SKYBODY_INLINE Real wait(Random<Real>& draw) const {
    return -gust_interval_.value() * log(draw.uniform());
  }

  template <class Real>
  SKYBODY_INLINE Vec3<Real> direction(Random<Real>& draw) const {
    const SinCos<Real> heading = sincos(draw.uniform(Real(-kPi), Real(kPi)));
    if (gust_direction_.count() == 0) return {heading.cos, heading.sin, Real(0.0)};
    return {Real(fixed_direction_.x), Real(fixed_direction_.y), Real(fixed_direction_.z)};
  }

  /// The 1-cosine gust; when it is over, draws the next one.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> gust(const EnvView<Real>& env, const Real& time,
                                 State<Real>& state) const {
    const Real duration = gust_duration_(env), age = time - state.begin;
    const auto is_on = logical_and(age > 0.0, age < duration);
    const Real phase = (2.0 * kPi) * (age / duration);
    const Real speed =
        (0.5 * gust_speed_(env)) * (1.0 - sincos(select(is_on, phase, Real(0.0))).cos);
    const Vec3<Real> velocity = state.direction * speed;
    const auto is_over = age >= duration;
    if (any(is_over)) {
      Random<Real> draw = random(env, kApplyDraws);
      state.begin = select(is_over, time + wait(draw), state.begin);
      state.direction = select(is_over, direction(draw), state.direction);
    }
    return velocity;
  }

  TextsParameter robots_{this, words("robots", "affected robots; empty: all")};
  RealsParameter velocity_{
      this, randomizable(reals("velocity", "m/s", {0.0, 0.0, 0.0}, between(-100.0, 100.0),
                               "velocity of the steady wind, W axes"))};
  RealParameter gust_speed_{this, randomizable(real("gust_speed", "m/s", 0.0, between(0.0, 100.0),
                                                    "speed of a gust at its peak; 0: no gusts"))};
  RealParameter gust_duration_{
      this, randomizable(real("gust_duration", "s", 1.0, between(0.001, 1000.0),
                              "duration of a gust, from still air to still air"))};
  RealParameter gust_interval_{this, real("gust_interval", "s", 5.0, between(0.001, 1e6),
                                          "mean time from the end of a gust to the next one")};
  RealsParameter gust_direction_{
      this,
      list("gust_direction", "", {}, kAny, "direction of all gusts, W axes; empty: random, level")};
  TextParameter profile_name_{this,
                              choice("profile", "uniform", {"uniform", "power", "logarithmic"},
                                     "growth of wind and gusts with a body's height z in W; power: "
                                     "by exponent, logarithmic: by roughness")};
  RealParameter reference_height_{this, real("reference_height", "m", 10.0, between(0.01, 10000.0),
                                             "height of `velocity` and `gust_speed`")};
  RealParameter least_height_{this, real("least_height", "m", 0.1, between(0.001, 1000.0),
                                         "height below which the wind is constant")};
  RealParameter exponent_{this, randomizable(real("exponent", "", 1.0 / 7.0, between(0.0, 1.0),
                                                  "exponent of the power profile"))};
  RealParameter roughness_{this,
                           randomizable(real("roughness", "m", 0.04572, between(1e-6, kRoughest),
                                             "logarithmic profile: height of zero wind"))};
  IntegerParameter period_{this, integer("period", "physics steps", 1, between(1, 1000000),
                                         "interval of new wind values")};

  double dt_ = 0.0;
  Profile profile_ = Profile::kUniform;
  std::vector<int> bodies_;
  Vec3<double> fixed_direction_{};
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Wind, "wind", "1.0.0", "Steady wind and 1-cosine gusts [m/s].");
