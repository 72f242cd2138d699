// An effect: a magnet at a point pulls a robot's base, by strength / (distance^2 + radius^2).
#include <skybody/plugin.h>

namespace skybody {
namespace {

class Magnet : public Effect {
 public:
  void configure(const Setup& setup) override {
    body_ = setup.robots()[setup.robot(robot_.value())].first_body;
    setup.holds(HeldInput::kWrench);
  }

  /// Before every physics step; Real holds one environment, or several side by side.
  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>&, Held<Real>& held) const {
    const Vec3<Real> place{Real(place_.value(0)), Real(place_.value(1)), Real(place_.value(2))};
    const Vec3<Real> offset = place - env.body(body_).position;
    const Real distance = norm(offset) + 1e-9;
    const Real force = strength_(env) / (distance * distance + radius_.value() * radius_.value());
    held.add_wrench(body_, offset * (force / distance), {Real(0.0), Real(0.0), Real(0.0)});
  }

 private:
  TextParameter robot_{this, word("robot", "", "name of the robot; empty: the only one")};
  RealsParameter place_{this, reals("place", "m", {0.0, 0.0, 1.5}, kAny, "the magnet (W)")};
  RealParameter radius_{this, real("radius", "m", 0.5, at_least(0.01), "half force at this")};
  RealParameter strength_{
      this, randomizable(real("strength", "N m^2", 0.5, at_least(0.0), "force times distance^2"))};

  int body_ = 0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Magnet, "magnet", "0.1.0", "A magnet at a point pulls a robot's base.");
