// Force and moment in world axes at the centres of mass of named links.
#include <vector>

#include "controllers/common/allocation.h"

namespace skybody {
namespace {

class Wrench : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    std::vector<std::string> links = links_.values();
    if (links.empty()) links = {setup.bodies()[control::base_of(setup, robot)].name};
    const double weight = control::total_mass(setup, robot) * control::gravity_of(setup);
    force_ = control::force_limit(max_force_, {2.0 * weight, 2.0 * weight, 2.0 * weight});
    moment_ = moment_limit(setup, robot);
    std::vector<double> high;
    for (std::size_t i = 0; i < links.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        if (links[k] == links[i]) {
          refuse("`links` names `", links[i], "` twice: name each link once");
        }
      }
      const LinkInfo& link = setup.link(robot, links[i]);
      setup.site({link.body, {link.com[0], link.com[1], link.com[2]}, 0, 1});
      high.insert(high.end(), {force_.x, force_.y, force_.z, moment_.x, moment_.y, moment_.z});
    }
    std::vector<double> low;
    for (const double h : high) low.push_back(-h);
    sites_ = static_cast<int>(links.size());
    setup.input(Signal::kWrench, low, high);
    setup.output(Signal::kWrench, 6 * sites_);
  }

  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> input,
               Values<Real> output) const {
    for (int i = 0; i < sites_; ++i) {
      output.set(6 * i, control::clamp_symmetric(input.vec3(6 * i), force_));
      output.set(6 * i + 3, control::clamp_symmetric(input.vec3(6 * i + 3), moment_));
    }
  }

 private:
  /// The rotors' largest torques by default.
  Vec3<double> moment_limit(const Setup& setup, int robot) const {
    const Vec3<double> given = max_moment_.vec3();
    if (control::all_above_zero(given)) return given;
    const View<RotorInfo> rotors = setup.rotors_of(robot);
    const BodyInfo& base = setup.bodies()[control::base_of(setup, robot)];
    const Vec3<double> possible =
        rotors.size() > 0
            ? control::limits_of(control::working_rotors(setup, robot, "wrench"), base).torque
            : Vec3<double>{0.0, 0.0, 0.0};
    const Vec3<double> limit = control::or_else(given, possible);
    if (!control::all_above_zero(limit)) {
      refuse("the rotors of robot `", control::robot_name(setup, robot),
             "` give no limits for all three moments: give `max_moment` three values above 0");
    }
    return limit;
  }

  TextsParameter links_{
      this, words("links", "links with a wrench at their centres of mass; none: the base")};
  RealsParameter max_force_{this, reals("max_force", "N", {0.0, 0.0, 0.0}, at_least(0.0),
                                        "forces for action +1; 0: twice the robot's weight")};
  RealsParameter max_moment_{this, reals("max_moment", "N m", {0.0, 0.0, 0.0}, at_least(0.0),
                                         "moments for action +1; 0: the rotors' largest moments")};

  Vec3<double> force_{}, moment_{};
  int sites_ = 0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Wrench, "wrench", "1.0.0",
               "Applies a force [N] and a moment [N m] in world axes at named links.");
