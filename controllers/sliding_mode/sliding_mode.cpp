// Follows a trajectory in sliding mode: position and attitude are driven onto surfaces on which
// their errors decay, by switching terms smoothed in a boundary layer. Chain `ctbt` next.
#include "controllers/common/trajectory_law.h"

namespace skybody {
namespace {

/// Bandwidth of the attitude loop inside its boundary layer with default values [rad/s].
constexpr double kRateGain = 22.0;

class SlidingMode : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    law_.configure(setup, true);
    const double share = control::lag_share(setup, setup.robot(), kRateGain);
    position_.configure(share);
    attitude_.configure(share);
    limits_.configure(setup);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input, Values<Real> output,
               Values<Real> buffer) const {
    const control::Followed<Real> now = law_.followed(env, input);
    const Vec3<Real> push = position_.drive(env, now.offset(), now.slip());
    const auto track = law_.push(now, limits_.thrust(push + law_.forward(now), buffer), output);
    const Vec3<Real> turn =
        attitude_.drive(env, track.error, track.rates - now.base.angular_velocity);
    law_.turn(now, track.acceleration + turn, output);
  }

 private:
  /// A surface s = de/dt + slope e, with e the remaining error, and the command that drives s to 0.
  class Surface {
   public:
    struct Names {
      const char *slope, *gain, *boundary, *gain_unit, *boundary_unit;
    };
    Surface(Plugin* owner, const Names& names, std::vector<double> slope, std::vector<double> gain,
            std::vector<double> boundary)
        : slope_(owner, randomizable(reals(names.slope, "1/s", std::move(slope), at_least(0.0),
                                           "rate at which the error decays on the surface"))),
          gain_(owner,
                randomizable(reals(names.gain, names.gain_unit, std::move(gain), at_least(0.0),
                                   "acceleration towards the surface outside the boundary layer"))),
          boundary_(owner, reals(names.boundary, names.boundary_unit, std::move(boundary),
                                 at_least(1e-6), "half the boundary layer's thickness")) {}

    /// @param share  factor on default rates (lag_share)
    void configure(double share) {
      slope_share_ = slope_.is_given() ? 1.0 : share;
      // The slope within the layer is gain / boundary: a rate.
      gain_share_ = gain_.is_given() || boundary_.is_given() ? 1.0 : share;
      const Vec3<double> b = boundary_.vec3();
      per_boundary_ = {1.0 / b.x, 1.0 / b.y, 1.0 / b.z};
    }

    /// slope de/dt + gain sat(s / boundary)
    template <class Real>
    SKYBODY_INLINE Vec3<Real> drive(const EnvView<Real>& env, const Vec3<Real>& error,
                                    const Vec3<Real>& rate) const {
      const Vec3<Real> slope = slope_.vec3(env) * Real(slope_share_);
      const Vec3<Real> s = rate + multiply_elements(slope, error);
      const Vec3<Real> share = multiply_elements(s, control::lift<Real>(per_boundary_));
      return multiply_elements(slope, rate) +
             multiply_elements(gain_.vec3(env) * Real(gain_share_),
                               control::clamp_symmetric(share, {1.0, 1.0, 1.0}));
    }

   private:
    RealsParameter slope_, gain_, boundary_;
    double slope_share_ = 1.0, gain_share_ = 1.0;
    Vec3<double> per_boundary_{};
  };

  Surface position_{this,
                    {"position_slope", "position_gain", "position_boundary", "m/s^2", "m/s"},
                    {1.5, 1.5, 2.0},
                    {4.0, 4.0, 5.0},
                    {1.4, 1.4, 1.4}};
  Surface attitude_{this,
                    {"attitude_slope", "attitude_gain", "attitude_boundary", "rad/s^2", "rad/s"},
                    {6.0, 6.0, 3.0},
                    {48.0, 48.0, 12.0},
                    {3.0, 3.0, 2.0}};
  control::ReportedLimits limits_{this, control::kTrajectoryLimits};
  control::TrajectoryLaw law_{this};
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::SlidingMode, "sliding_mode", "1.0.0",
               "Follows a trajectory in sliding mode; output: ctbt.");
