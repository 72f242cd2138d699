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
      throw std::runtime_error("`gust_duration` is " + to_text(gust_duration_.value()) +
                               " s, but the effect is called every " + to_text(longest) +
                               " s: allowed are at least two calls a gust; lower `period`");
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
      throw std::runtime_error(
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
      throw std::runtime_error(
          "`reference_height` is " + to_text(reference_height_.value()) +
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

  TextsParameter robots_{this, {.name = "robots", .doc = "affected robots; empty: all"}};
  RealsParameter velocity_{this,
                           {.name = "velocity",
                            .unit = "m/s",
                            .values = {0.0, 0.0, 0.0},
                            .min = -100.0,
                            .max = 100.0,
                            .doc = "velocity of the steady wind, W axes",
                            .randomizable = true}};
  RealParameter gust_speed_{this,
                            {.name = "gust_speed",
                             .unit = "m/s",
                             .min = 0.0,
                             .max = 100.0,
                             .doc = "speed of a gust at its peak; 0: no gusts",
                             .randomizable = true}};
  RealParameter gust_duration_{this,
                               {.name = "gust_duration",
                                .unit = "s",
                                .value = 1.0,
                                .min = 0.001,
                                .max = 1000.0,
                                .doc = "duration of a gust, from still air to still air",
                                .randomizable = true}};
  RealParameter gust_interval_{this,
                               {.name = "gust_interval",
                                .unit = "s",
                                .value = 5.0,
                                .min = 0.001,
                                .max = 1e6,
                                .doc = "mean time from the end of a gust to the next one"}};
  RealsParameter gust_direction_{this,
                                 {.name = "gust_direction",
                                  .count = -1,
                                  .doc = "direction of all gusts, W axes; empty: random, level"}};
  TextParameter profile_name_{this,
                              {.name = "profile",
                               .value = "uniform",
                               .choices = {"uniform", "power", "logarithmic"},
                               .doc = "growth of wind and gusts with a body's height z in W; "
                                      "power: by exponent, logarithmic: by roughness"}};
  RealParameter reference_height_{this,
                                  {.name = "reference_height",
                                   .unit = "m",
                                   .value = 10.0,
                                   .min = 0.01,
                                   .max = 10000.0,
                                   .doc = "height of `velocity` and `gust_speed`"}};
  RealParameter least_height_{this,
                              {.name = "least_height",
                               .unit = "m",
                               .value = 0.1,
                               .min = 0.001,
                               .max = 1000.0,
                               .doc = "height below which the wind is constant"}};
  RealParameter exponent_{this,
                          {.name = "exponent",
                           .value = 1.0 / 7.0,
                           .min = 0.0,
                           .max = 1.0,
                           .doc = "exponent of the power profile",
                           .randomizable = true}};
  RealParameter roughness_{this,
                           {.name = "roughness",
                            .unit = "m",
                            .value = 0.04572,
                            .min = 1e-6,
                            .max = kRoughest,
                            .doc = "logarithmic profile: height of zero wind",
                            .randomizable = true}};
  IntegerParameter period_{this,
                           {.name = "period",
                            .unit = "physics steps",
                            .value = 1,
                            .min = 1,
                            .max = 1000000,
                            .doc = "interval of new wind values"}};

  double dt_ = 0.0;
  Profile profile_ = Profile::kUniform;
  std::vector<int> bodies_;
  Vec3<double> fixed_direction_{};
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Wind, "wind", "1.0.0", "Steady wind and 1-cosine gusts [m/s].");
