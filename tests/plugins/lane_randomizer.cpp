// Draws a parameter and an initial state; counts resets in a state that persists across them.
#include <skybody/plugin.h>

namespace {

using namespace skybody;

class LaneRandomizer : public Randomizer {
 public:
  template <class Real>
  struct State {
    Word<Real> resets;
  };

  void configure(const Setup& setup) override { setup.writes(0); }

  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>& state, Start<Real>& start) const {
    state.resets += 1;
    auto draw = random(env);
    start.params.set(0, draw.uniform(Real(spread_.value(0)), Real(spread_.value(1))));
    start.q.set(0, draw.unit_vector());
    start.q.set(3, draw.quaternion());
    start.rotor_speed.set(0, select((state.resets & 1) == Word<Real>(1), Real(100.0), Real(200.0)));
  }

 private:
  RealsParameter spread_{this,
                         {.name = "spread", .values = {0.5, 1.5}, .count = 2, .doc = "range"}};
};

}  // namespace

SKYBODY_PLUGIN(LaneRandomizer, "lane_randomizer", "1.0.0", "Draws a start.");
