// A task: visit three points in an order that is drawn for each episode. docs/task_kit.md quotes
// the parts between `// [NAME]` and `// [end]`.
// [include]
#include <skybody/task_kit.h>
// [end]

namespace skybody {
namespace {

using namespace task_kit;

class VisitPoints : public Task {
 public:
  // [state]
  template <class Real>
  struct State {
    Real order[3];  // which point is the first, the second, the third
    Real visited;   // how many so far
    Real distance;  // from the next one, at the step before [m]
  };
  // [end]

  void configure(const Setup& setup) override {
    const int robot = setup.robot("");  // the only one
    body_ = setup.robots()[robot].first_body;
    offset_ = parts_.add(setup, {"offset", "m", 3, "next point - p, W"});
    velocity_ = parts_.add(setup, {"velocity", "m/s", 3, "of the base's frame, W"});
    attitude_ = parts_.add(setup, {"attitude", "", 4, "w x y z, W from B, w >= 0", -1.0, 1.0});
    rates_ = parts_.add(setup, {"angular_velocity", "rad/s", 3, "B"});
    visited_ = infos_.add(setup, "visited", "", "points so far");
    limits_.configure(setup, infos_);
    // [declare]
    low_ = declare_failure(setup, infos_, "height", "below `height_min`");
    // [end]
    success_ = declare_success(setup, infos_, "all points are visited, which ends the episode");
    setup.goal(robot, body_);
  }

  // [reset]
  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state) const {
    Random<Real> draw = random(env);
    state.order[0] = to_real(draw.integer(3));  // a Word becomes a Real
    const Real next = state.order[0] + 1.0 + to_real(draw.integer(2));
    state.order[1] = select(next >= 3.0, next - 3.0, next);
    state.order[2] = 3.0 - state.order[0] - state.order[1];
    state.visited = Real(0.0);
  }
  // [end]

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>& state, Evaluation<Real>& out) const {
    const BodyMotion<Real> body = env.body(body_);
    // [progress]
    const Real distance = norm(next_point(state) - body.position);
    const Real gain = progress(env, distance, state.distance);
    state.visited = state.visited + choose(distance < reach_.value(), Real(1.0), Real(0.0));
    const Vec3<Real> offset = next_point(state) - body.position;
    state.distance = norm(offset);  // from the new point, if it has just changed
    // [end]

    offset_.set(out.observation, offset);
    velocity_.set(out.observation, body.velocity);
    attitude_.set(out.observation, canonical(body.rotation));
    rates_.set(out.observation, body.angular_velocity);
    if (out.wants_info()) visited_.set(out.info, state.visited);

    Verdict<Real> verdict(out);
    limits_.judge(verdict, limits_.passed(body));
    // [verdict]
    verdict.fail(low_, body.position.z < height_min_.value());
    // [end]
    out.set_reward(gain + choose(verdict.failed(), Real(-10.0), Real(0.0)));
    // [finish]
    verdict.finish(success_, state.visited > 2.5);
    // [end]
  }

  template <class Real>
  void goal(const EnvView<Real>&, const State<Real>& state, Values<Real> goal) const {
    goal.set(0, next_point(state));
    goal.set(3, Real(0.0));
  }

 private:
  /// The next point to visit; the last one if all are visited.
  template <class Real>
  Vec3<Real> next_point(const State<Real>& state) const {
    // [select]
    Real which = state.order[0];
    for (int i = 1; i < 3; ++i) which = select(state.visited > i - 0.5, state.order[i], which);
    // [end]
    Vec3<Real> point = place<Real>(0);
    for (int i = 1; i < 3; ++i) point = choose(which > i - 0.5, place<Real>(i), point);
    return point;
  }
  template <class Real>
  Vec3<Real> place(int i) const {
    return {Real(points_.value(3 * i)), Real(points_.value(3 * i + 1)),
            Real(points_.value(3 * i + 2))};
  }

  RealsParameter points_{this, reals("points", "m", {2.0, 0.0, 1.0, 0.0, 2.0, 1.5, -1.0, -1.0, 2.0},
                                     kAny, "x, y, z of the three (W), one after another")};
  RealParameter reach_{
      this, real("reach", "m", 0.2, at_least(1e-3), "a point is visited nearer than this")};
  RealParameter height_min_{this, real("height_min", "m", 0.2, kAny, "a robot fails below this")};
  FlightLimits limits_{this};

  ObservationParts parts_;
  InfoParts infos_;
  Part offset_, velocity_, attitude_, rates_, visited_, low_, success_;
  int body_ = 0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::VisitPoints, "visit_points", "0.1.0",
               "Visit three points in an order that is drawn for each episode.");
