// Drag of bodies in the air: linear and quadratic along each body axis.
#include <skybody/plugin.h>

#include <vector>

#include "effects/common/robots.h"

namespace skybody {
namespace {

class BodyDrag : public Effect {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    for (const int r : effect::robots_called(setup, robots_.values())) {
      bodies_.push_back(link_.value().empty() ? setup.robots()[r].first_body
                                              : setup.link(r, link_.value()).body);
    }
    setup.holds(HeldInput::kBodyDrag);
    setup.steady();
  }

  /// Sets the coefficients; the engine evaluates the force at every stage of the integrator.
  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>&, Held<Real>& held) const {
    const Vec3<Real> linear = linear_.vec3(env), quadratic = quadratic_.vec3(env);
    for (const int body : bodies_) held.add_drag(body, linear, quadratic);
  }

 private:
  TextsParameter robots_{this, words("robots", "affected robots; empty: all")};
  TextParameter link_{
      this, word("link", "", "link of the affected body, of each robot; empty: the base")};
  RealsParameter linear_{
      this, randomizable(reals("linear", "N s/m", {0.0, 0.0, 0.0}, between(0.0, 1e6),
                               "linear coefficients along the body's x, y and z axis"))};
  RealsParameter quadratic_{
      this, randomizable(reals(
                "quadratic", "N s^2/m^2", {0.0, 0.0, 0.0}, between(0.0, 1e6),
                "coefficients along these axes, of the speed times the velocity along the axis"))};

  std::vector<int> bodies_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::BodyDrag, "body_drag", "1.0.0",
               "Linear and quadratic drag of bodies along each body axis.");
