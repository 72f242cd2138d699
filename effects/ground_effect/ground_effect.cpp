// Ground effect: rotors near the ground give more thrust, with a gain by the hub's height above z =
// 0.
#include <skybody/plugin.h>

#include <vector>

#include "effects/common/hubs.h"
#include "effects/common/rotors.h"

namespace skybody {
namespace {

class GroundEffect : public Effect {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    carriers_ = effect::carriers_of(
        setup, effect::robots_with_one_way_rotors(setup, robots_.values(), "the ground effect"));
    is_gzdrl_ = form_.value() == "gzdrl";
    if (is_gzdrl_ && ground_constant_.value() == 0.0) {
      refuse(
          "`ground_constant` is 0, but `form: gzdrl` needs it: allowed are values above 0, such as "
          "the thrust constant times the rotor's squared radius over 16");
    }
    if (!is_gzdrl_ && radius_.value() == 0.0) {
      refuse(
          "`radius` is 0, but `form: cheeseman_bennett` needs it: allowed are values above 0; give "
          "the rotors' radius [m]");
    }
    setup.holds(HeldInput::kRotorGain);
  }

  /// Gains at the present hub positions, constant over the step.
  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>&, Held<Real>& held) const {
    const Real radius = radius_(env), least = max(least_height_ratio_(env) * radius, Real(kTiny));
    const Real constant = ground_constant_(env);
    effect::each_hub(
        carriers_, env,
        [&](const effect::Hub& hub, const Real& height, const Real& upright) SKYBODY_INLINE_LAMBDA {
          if (is_gzdrl_) {
            held.scale_thrust(hub.rotor, gzdrl(constant / env.param(hub.thrust_constant), height));
          } else {
            held.scale_thrust(hub.rotor, cheeseman_bennett(radius, max(height, least), upright));
          }
        });
  }

 private:
  static constexpr double kTiny = 1e-9;  ///< [m], for radii randomized to 0

  /// 1 / (1 - (R / 4 h)^2) with h = height / upright, the distance to the ground down the rotor's
  /// axis; 1 for a rotor that does not blow down.
  template <class Real>
  static SKYBODY_INLINE Real cheeseman_bennett(const Real& radius, const Real& height,
                                               const Real& upright) {
    const Real share = (0.25 * radius) * max(upright, Real(0.0)) / height;
    return 1.0 / (1.0 - share * share);
  }
  /// Added thrust K w^2 / h^2 relative to the thrust k_f w^2, for any attitude.
  /// @param ratio  K / k_f [m^2]
  template <class Real>
  static SKYBODY_INLINE Real gzdrl(const Real& ratio, const Real& height) {
    const Real h = max(abs(height), Real(0.05));
    return 1.0 + ratio / (h * h);
  }

  TextsParameter robots_{
      this, words("robots", "robots whose rotors are affected; empty: all with rotors")};
  TextParameter form_{this, choice("form", "cheeseman_bennett", {"cheeseman_bennett", "gzdrl"},
                                   "equation of the gain")};
  RealParameter radius_{
      this, randomizable(real("radius", "m", 0.0, between(0.0, 100.0),
                              "radius of each rotor; above 0 with form cheeseman_bennett"))};
  RealParameter least_height_ratio_{
      this, randomizable(real("least_height_ratio", "", 0.5, between(0.3, 10.0),
                              "height over radius below which the gain is constant"))};
  RealParameter ground_constant_{
      this, randomizable(real(
                "ground_constant", "N s^2 m^2/rad^2", 0.0, between(0.0, 1.0),
                "added thrust over speed squared, times height squared; above 0 with form gzdrl"))};

  std::vector<effect::Carrier> carriers_;
  bool is_gzdrl_ = false;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::GroundEffect, "ground_effect", "1.0.0",
               "More thrust of rotors near the ground z = 0.");
