// Fly to a point between obstacles, which are observed as the nearest surfaces, or by sensors.
#include <skybody/task_kit.h>

#include <string>
#include <vector>

#include "tasks/obstacles/guide.h"
#include "tasks/obstacles/sight.h"

namespace skybody {
namespace {

using namespace task_kit;
using obstacles::Guide;
using obstacles::Obstacle;
using obstacles::Sight;

class Obstacles : public Task {
 public:
  static constexpr bool kSmooth = true;

  template <class Real>
  struct State {
    Real distance;  ///< from the target at the last step [m]
  };

  void configure(const Setup& setup) override {
    target_.configure(setup);
    target_.require_within(limits_.bound());
    target_.require_above(height_min_.value());
    obstacles_ = obstacles::find(setup, "task `obstacles`");
    require_obstacles();
    robot_.configure(setup, "obstacles");
    declare_observation(setup);
    distance_info_ = infos_.add(setup, "position_error", "m", "distance from the target");
    clearance_info_ =
        infos_.add(setup, "clearance", "m", "distance of the nearest surface minus `radius`");
    speed_info_ = infos_.add(setup, "speed", "m/s", "speed of the base's frame");
    limits_.configure(setup, infos_);
    collision_failure_ =
        declare_failure(setup, infos_, "collision", "a surface nearer than `radius`");
    ground_failure_ = declare_failure(setup, infos_, "ground", "below `height_min`");
    success_ = declare_success(setup, infos_,
                               "within `success_distance` of the target, which ends the episode");
    setup.goal(robot_.index(), robot_.body());
  }

  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>&, Start<Real>& start) const {
    target_.randomize(random(env), start);
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>& state, Evaluation<Real>& out) const {
    const BodyMotion<Real> body = env.body(robot_.body());
    const Vec3<Real> error = target_.position(env) - body.position;
    const Sight<Real> sight =
        obstacles::look(env, obstacles_, body.position, seen(), view_.value());
    observe(env, body, error, sight, out.observation);

    const Real distance = norm(error), clearance = sight.nearest - radius_.value();
    const PassedLimits<Real> passed = limits_.passed(body);
    const auto collides = clearance < 0.0, low = body.position.z < height_min_.value();
    const auto failed = logical_or(passed.any(), logical_or(collides, low));
    const auto arrived = distance < success_distance_.value();
    const Real gain = progress(env, distance, state.distance);
    out.set_reward(reward(body, gain, clearance, failed, arrived));

    Verdict<Real> verdict(out);
    limits_.judge(verdict, passed);
    verdict.fail(collision_failure_, collides);
    verdict.fail(ground_failure_, low);
    verdict.finish(success_, arrived);
    if (!out.wants_info()) return;
    distance_info_.set(out.info, distance);
    clearance_info_.set(out.info, clearance);
    speed_info_.set(out.info, norm(body.velocity));
  }

  /// A point ahead on a way between the obstacles; near the target, the target itself.
  template <class Real>
  void goal(const EnvView<Real>& env, const State<Real>&, Values<Real> goal) const {
    const BodyMotion<Real> body = env.body(robot_.body());
    const Vec3<Real> target = target_.position(env);
    const Vec3<Real> way = Guide::way(env, obstacles_, body.position, target, body.velocity,
                                      radius_.value() + safe_distance_.value());
    const Real x = target.x - body.position.x, y = target.y - body.position.y;
    const auto near = x * x + y * y < lead_.value() * lead_.value();
    goal.set(0, select(near, target.x, body.position.x + lead_.value() * way.x));
    goal.set(1, select(near, target.y, body.position.y + lead_.value() * way.y));
    goal.set(2, target.z);
    goal.set(3, Real(0.0));
  }

 private:
  /// Columns of one observed obstacle.
  struct SeenParts {
    Part way, distance, size;
  };

  int seen() const { return static_cast<int>(nearest_.value()); }

  void require_obstacles() const {
    const int count = static_cast<int>(obstacles_.size());
    if (count == 0) {
      refuse(
          "the scenario has no obstacles: add some, or take task `hover`, which flies to a point");
    }
    if (seen() <= count) return;
    refuse("`nearest` is ", seen(), ", and there ",
           (count == 1 ? "is 1 obstacle" : "are " + std::to_string(count) + " obstacles"),
           ": take no more than there are");
  }

  void declare_observation(const Setup& setup) {
    const RobotParts part(setup, observation_, robot_.index());
    error_ = part("position_error", "m", 3, "target - position, W");
    motion_.declare(part);
    robot_.action.declare(part);
    for (int k = 0; k < seen(); ++k) {
      const std::string name = "nearest_" + std::to_string(k + 1) + ".";
      const double view = view_.value();
      parts_.push_back(
          {part(name + "way", "m", 3,
                "vector to the nearest point of its surface, W; 0: beyond `view`"),
           part(name + "distance", "m", 1,
                "distance of that point, below 0 inside; `view` beyond it", -kInfinity, view),
           part(name + "size", "m", 3, "size of the obstacle as in the scenario; 0: beyond `view`",
                0.0, kInfinity)});
    }
  }

  template <class Real>
  SKYBODY_INLINE void observe(const EnvView<Real>& env, const BodyMotion<Real>& body,
                              const Vec3<Real>& error, const Sight<Real>& sight,
                              const Values<Real>& row) const {
    error_.set(row, error);
    motion_.set(row, body);
    robot_.action.set(env, row);
    for (int k = 0; k < seen(); ++k) {
      const SeenParts& parts = parts_[static_cast<std::size_t>(k)];
      parts.way.set(row, sight.seen[k].way);
      parts.distance.set(row, sight.seen[k].distance);
      parts.size.set(row, sight.seen[k].size);
    }
  }

  template <class Real>
  SKYBODY_INLINE Real reward(const BodyMotion<Real>& body, const Real& gain, const Real& clearance,
                             const MaskOf<Real>& failed, const MaskOf<Real>& arrived) const {
    const Real zero(0.0);
    const Real lack = max(zero, 1.0 - max(clearance, zero) / safe_distance_.value());
    const Real arrival = choose(arrived, Real(success_reward_.value()), zero);
    return progress_reward_.value() * gain - clearance_cost_.value() * lack * lack -
           rate_cost_.value() * squared_norm(body.angular_velocity) +
           choose(failed, Real(failure_reward_.value()), arrival);
  }

  OneRobot robot_{this};
  DrawnTarget target_{
      this, {.target = {6.0, 0.0, 1.2}, .low = {5.5, -2.0, 1.0}, .high = {6.5, 2.0, 1.4}}};
  IntegerParameter nearest_{
      this,
      integer(
          "nearest", "", 4, between(0, obstacles::kMostSeen),
          "number of observed obstacles, the nearest first; 0: none, if a sensor observes them")};
  RealParameter view_{
      this, real("view", "m", 4.0, between(1e-3, 1e6), "range in which obstacles are observed")};
  RealParameter radius_{this, real("radius", "m", 0.2, between(0.0, 100.0),
                                   "radius of the robot: a nearer surface is a collision")};
  RealParameter height_min_{
      this, real("height_min", "m", 0.1, kAny, "a robot fails below this height (W z)")};
  FlightLimits limits_{this};
  RealParameter success_distance_{this,
                                  real("success_distance", "m", 0.3, at_least(0.0),
                                       "the robot has arrived if nearer than this to the target")};
  RealParameter progress_reward_{this, real("progress_reward", "1/m", 1.0, at_least(0.0),
                                            "reward per metre of approach to the target")};
  RealParameter safe_distance_{
      this,
      real("safe_distance", "m", 0.3, at_least(1e-3),
           "a smaller clearance costs reward; the baseline keeps this clearance if possible")};
  RealParameter clearance_cost_{
      this, real("clearance_cost", "", 0.1, at_least(0.0),
                 "cost of a step at zero clearance; quadratic up to `safe_distance`")};
  RealParameter rate_cost_{this, real("rate_cost", "s^2/rad^2", 0.001, at_least(0.0),
                                      "cost per squared angular velocity")};
  RealParameter success_reward_{
      this, real("success_reward", "", 5.0, at_least(0.0), "reward of the step that arrives")};
  RealParameter failure_reward_{this, real("failure_reward", "", -5.0, at_most(0.0),
                                           "reward of the step in which the robot fails")};
  RealParameter lead_{this, real("lead", "m", 0.6, at_least(0.01),
                                 "distance of the baseline's goal ahead, which sets its speed")};

  ObservationParts observation_;
  InfoParts infos_;
  Part error_;
  MotionParts motion_;
  std::vector<SeenParts> parts_;
  Part distance_info_, clearance_info_, speed_info_;
  Part collision_failure_, ground_failure_, success_;
  std::vector<Obstacle> obstacles_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Obstacles, "obstacles", "1.0.0", "Fly to a point between obstacles.");
