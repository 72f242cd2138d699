// Hovering at a random height: observation, reward, both kinds of ends, its own scaling, a goal.
#include <skybody/plugin.h>

namespace {

using namespace skybody;

class LaneTask : public Task {
 public:
  static constexpr bool kSmooth = true;

  template <class Real>
  struct State {
    Real target;
  };

  void configure(const Setup& setup) override {
    setup.channel("error", "m", 3, -kInfinity, kInfinity);
    setup.channel("action", "", 1, -1.0, 1.0);
    setup.goal(0, 0);
  }

  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state) const {
    state.target = random(env).uniform(Real(1.0), Real(2.0));
  }

  template <class Real>
  void process(const EnvView<Real>& env, State<Real>& state, ConstValues<Real> action,
               Values<Real> command) const {
    command.set(0, 500.0 + 100.0 * action[0] + state.target + to_real(env.step()));
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>& state, Evaluation<Real>& out) const {
    const Vec3<Real> p = env.body(0).position;
    const Vec3<Real> error{p.x, p.y, p.z - state.target};
    out.observation.set(0, error);
    out.observation.set(3, env.action(0));
    out.set_reward(exp(-norm(error)));
    out.terminate(p.z < 0.0);
    out.truncate(norm(error) > 5.0);
  }

  template <class Real>
  void goal(const EnvView<Real>&, const State<Real>& state, Values<Real> goal) const {
    goal.set(0, Vec3<Real>{Real(0.0), Real(0.0), state.target});
    goal.set(3, Real(0.0));
  }
};

}  // namespace

SKYBODY_PLUGIN(LaneTask, "lane_task", "1.0.0", "Hovers at a drawn height.");
