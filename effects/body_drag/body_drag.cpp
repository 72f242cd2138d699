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
  TextsParameter robots_{this, {.name = "robots", .doc = "affected robots; empty: all"}};
  TextParameter link_{
      this, {.name = "link", .doc = "link of the affected body, of each robot; empty: the base"}};
  RealsParameter linear_{this,
                         {.name = "linear",
                          .unit = "N s/m",
                          .values = {0.0, 0.0, 0.0},
                          .min = 0.0,
                          .max = 1e6,
                          .doc = "linear coefficients along the body's x, y and z axis",
                          .randomizable = true}};
  RealsParameter quadratic_{
      this,
      {.name = "quadratic",
       .unit = "N s^2/m^2",
       .values = {0.0, 0.0, 0.0},
       .min = 0.0,
       .max = 1e6,
       .doc = "coefficients along these axes, of the speed times the velocity along the axis",
       .randomizable = true}};

  std::vector<int> bodies_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::BodyDrag, "body_drag", "1.0.0",
               "Linear and quadratic drag of bodies along each body axis.");
