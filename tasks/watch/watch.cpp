// Runs a world and observes one of its links: no goal, no reward, no termination.
#include <skybody/plugin.h>

namespace skybody {
namespace {

class Watch : public Task {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    link_ = setup.link(setup.robot(robot_.value()), link_name_.value());
    setup.channel("position", "m", 3, -kInfinity, kInfinity);
    setup.channel("attitude", "", 4, -1.0, 1.0);
    setup.channel("velocity", "m/s", 3, -kInfinity, kInfinity);
    setup.channel("angular_velocity", "rad/s", 3, -kInfinity, kInfinity);
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out) const {
    const BodyMotion<Real> body = env.body(link_.body);
    const Vec3<Real> place{Real(link_.position[0]), Real(link_.position[1]),
                           Real(link_.position[2])};
    const Quat<Real> turn{Real(link_.rotation[0]), Real(link_.rotation[1]), Real(link_.rotation[2]),
                          Real(link_.rotation[3])};
    out.observation.set(0, body.position + rotate(body.rotation, place));
    out.observation.set(3, body.rotation * turn);
    out.observation.set(7,
                        body.velocity + rotate(body.rotation, cross(body.angular_velocity, place)));
    out.observation.set(10, rotate_inverse(turn, body.angular_velocity));
    out.set_reward(Real(0.0));
  }

 private:
  TextParameter robot_{this, word("robot", "", "robot with the link; empty: the only robot")};
  TextParameter link_name_{this, required(word("link", "", "name of the link"))};
  LinkInfo link_{};
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Watch, "watch", "1.0.0",
               "Runs a world and observes one link, without goal, reward or end.");
