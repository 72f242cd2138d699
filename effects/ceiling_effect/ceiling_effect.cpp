// Ceiling effect: rotors below a level ceiling give more thrust, with a gain by the hub's distance
// from it.
#include <skybody/plugin.h>

#include <vector>

#include "effects/common/hubs.h"
#include "effects/common/rotors.h"

namespace skybody {
namespace {

class CeilingEffect : public Effect {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    carriers_ = effect::carriers_of(
        setup, effect::robots_with_one_way_rotors(setup, robots_.values(), "the ceiling effect"));
    check_height(setup);
    is_fitted_ = form_.value() == "fitted";
    if (is_fitted_) check_fit();
    setup.holds(HeldInput::kRotorGain);
  }

  /// Gains at the present hub positions, constant over the step.
  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>&, Held<Real>& held) const {
    const Real radius = radius_(env), ceiling = height_(env);
    const Real least = least_distance_ratio_(env) * radius;
    const Real factor = 1.0 / a1_(env), offset = a2_(env);
    effect::each_hub(
        carriers_, env,
        [&](const effect::Hub& hub, const Real& height, const Real& upright) SKYBODY_INLINE_LAMBDA {
          const Real distance = ceiling - height, bounded = max(distance, least);
          const Real facing = radius * max(upright, Real(0.0));
          const Real gain = is_fitted_ ? fitted(facing / (bounded + offset), factor)
                                       : constant_power(facing / bounded);
          held.scale_thrust(hub.rotor, select(distance > 0.0, gain, Real(1.0)));
        });
  }

 private:
  static constexpr double kLargestShare = 0.75;  ///< limit in the fit's denominator: gains up to 4

  /// Rejects a ceiling below the ground and below all affected robots.
  void check_height(const Setup& setup) const {
    double lowest = kInfinity;
    for (const effect::Carrier& carrier : carriers_) {
      lowest = min(lowest, setup.robots()[carrier.robot].position[2]);
    }
    if (height_.value() > 0.0 || height_.value() > lowest) return;
    refuse("`height` is ", height_.value(),
           " m, below the ground z = 0 and all robots (the lowest begins at ", lowest,
           " m): raise it");
  }

  void check_fit() const {
    if (a1_.value() == 0.0) {
      refuse(
          "`a1` is 0, but `form: fitted` needs it: allowed are values above 0; take those of a fit "
          "to measurements with these rotors");
    }
    const double ratio =
        radius_.value() / (least_distance_ratio_.value() * radius_.value() + a2_.value());
    const double share = ratio * ratio / a1_.value();
    if (share > kLargestShare) {
      refuse("with `a1` ", a1_.value(), " and `a2` ", a2_.value(), " m the thrust grows by ",
             (share < 1.0 ? to_text(1.0 / (1.0 - share)) : "more than any factor"),
             " at the least distance: allowed are factors up to 4; raise `a1`, `a2` or "
             "`least_distance_ratio`");
    }
  }

  /// Gain at constant rotor power, by momentum theory; see README.md.
  /// @param ratio  radius over distance
  template <class Real>
  static SKYBODY_INLINE Real constant_power(const Real& ratio) {
    const Real slower = 0.5 + 0.5 * sqrt(1.0 + 0.125 * (ratio * ratio));
    return exp((2.0 / 3.0) * log(slower));
  }
  /// Fitted gain.
  /// @param ratio  radius over the distance plus its offset
  template <class Real>
  static SKYBODY_INLINE Real fitted(const Real& ratio, const Real& factor) {
    return 1.0 / (1.0 - min(factor * (ratio * ratio), Real(kLargestShare)));
  }

  TextsParameter robots_{
      this, words("robots", "robots whose rotors are affected; empty: all with rotors")};
  RealParameter height_{this,
                        randomizable(required(real("height", "m", 0.0, between(-1000.0, 1000.0),
                                                   "z of the level ceiling in W")))};
  TextParameter form_{
      this, choice("form", "constant_power", {"constant_power", "fitted"}, "equation of the gain")};
  RealParameter radius_{this, randomizable(required(real("radius", "m", 0.0, between(0.0001, 100.0),
                                                         "radius of each rotor")))};
  RealParameter least_distance_ratio_{
      this, randomizable(real("least_distance_ratio", "", 0.2, between(0.01, 10.0),
                              "distance over radius below which the gain is constant"))};
  RealParameter a1_{this, randomizable(real("a1", "", 0.0, between(0.0, 1e6),
                                            "coefficient of the fit; above 0 with form fitted"))};
  RealParameter a2_{this, randomizable(real("a2", "m", 0.0, between(0.0, 100.0),
                                            "coefficient of the fit, added to the distance"))};

  std::vector<effect::Carrier> carriers_;
  bool is_fitted_ = false;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::CeilingEffect, "ceiling_effect", "1.0.0",
               "More thrust of rotors below a level ceiling.");
