// Drag of bodies in the air: linear and quadratic along each body axis.
#include <skybody/plugin.h>

#include <vector>

namespace skybody {
namespace {

class BodyDrag : public Effect {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    choose_bodies(setup);
    setup.holds(HeldInput::kBodyDrag);
  }

  /// The coefficients; the engine makes the force of them wherever the integrator asks for it.
  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>&, Held<Real>& held) const {
    const Vec3<Real> linear = linear_.vec3(env), quadratic = quadratic_.vec3(env);
    for (const int body : bodies_) held.add_drag(body, linear, quadratic);
  }

 private:
  /// Of each robot once, however often it is named: drag must not count twice.
  void choose_bodies(const Setup& setup) {
    std::vector<bool> chosen(static_cast<std::size_t>(setup.robots().size()),
                             robots_.values().empty());
    for (const std::string& name : robots_.values()) {
      chosen[static_cast<std::size_t>(setup.robot(name))] = true;
    }
    for (int r = 0; r < setup.robots().size(); ++r) {
      if (!chosen[static_cast<std::size_t>(r)]) continue;
      bodies_.push_back(link_.value().empty() ? setup.robots()[r].first_body
                                              : setup.link(r, link_.value()).body);
    }
  }

  TextsParameter robots_{this, {.name = "robots", .doc = "whom it acts on; empty: all"}};
  TextParameter link_{
      this, {.name = "link", .doc = "whose body is held back, of each robot; empty: the base"}};
  RealsParameter linear_{this,
                         {.name = "linear",
                          .unit = "N s/m",
                          .values = {0.0, 0.0, 0.0},
                          .min = 0.0,
                          .max = 1e6,
                          .doc = "coefficients along the body's x, y and z axis",
                          .randomizable = true}};
  RealsParameter quadratic_{this,
                            {.name = "quadratic",
                             .unit = "N s^2/m^2",
                             .values = {0.0, 0.0, 0.0},
                             .min = 0.0,
                             .max = 1e6,
                             .doc = "coefficients along these axes, of the whole speed times the "
                                    "velocity along the axis",
                             .randomizable = true}};

  std::vector<int> bodies_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::BodyDrag, "body_drag", "1.0.0",
               "Linear and quadratic drag of bodies, along each body axis.");
