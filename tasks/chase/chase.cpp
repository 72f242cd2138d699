// Pursuers catch an evader, which follows a reference or is an agent itself.
#include <skybody/task_kit.h>

#include <string>
#include <vector>

namespace skybody {
namespace {

using namespace task_kit;

class Chase : public Task {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const int evader = setup.robot(evader_.value());
    if (pen_.value() > limits_.bound()) {
      refuse("`pen` ", pen_.value(), " reaches beyond `bound` ", limits_.bound(),
             ", where an episode ends: raise that, or make the pen smaller");
    }
    add_pursuers(setup, evader);
    evades_ = setup.robots()[evader].action_count > 0;
    pursuers_ = count();
    add_robot(setup, evader);
    for (int i = 0; i < agents(); ++i) declare_observation(setup, i);
    for (int i = 0; i < agents(); ++i) setup.goal(at(i).index, at(i).body);
    setup.robot_rewards();
    evader_info_ = infos_.add(setup, "evader_distance", "m", "distance of the nearest pursuer");
    nearest_info_ =
        infos_.add(setup, "pursuers_distance", "m", "smallest distance between two pursuers");
    limits_.configure(setup, infos_);
    ground_failure_ = declare_failure(setup, infos_, "ground", "a pursuer below `height_min`");
    separation_failure_ =
        declare_failure(setup, infos_, "separation", "two pursuers nearer than `separation_min`");
    if (evades_) {
      evader_failure_ = declare_failure(setup, infos_, "evader",
                                        "the evader beyond a flight limit, or below `height_min`");
    }
    success_ = declare_success(setup, infos_,
                               "a pursuer within `capture_radius` of the evader, which ends the "
                               "episode");
    setup.buffer(memory_.size());
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out,
                Values<Real> buffer) const {
    for (int i = 0; i < agents(); ++i) observe(env, i, out.observation);
    Moment<Real> now;
    for (int i = 0; i < pursuers_; ++i) meet(env, i, now);
    const auto caught = now.distance < capture_radius_.value();
    Real team(0.0);
    for (int i = 0; i < pursuers_; ++i) {
      const Real own = pursuit(env, i, caught, buffer);
      out.set_reward(at(i).index, own);
      team += own;
    }
    out.set_reward(team / static_cast<double>(pursuers_));
    judge(env, now, caught, out);
    const Real evader = evades_ ? evasion(env, now, caught, buffer) : Real(0.0);
    out.set_reward(at(pursuers_).index, evader);
  }

  /// The first pursuer flies to the evader, the others to positions beside it, each on its own
  /// side. An evader that is an agent flies away from them, within its pen.
  template <class Real>
  void goal(const EnvView<Real>& env, const State<Real>&, Values<Real> goal) const {
    const Vec3<Real> evader = position(env, pursuers_);
    Vec3<Real> away{Real(0.0), Real(0.0), Real(0.0)};
    for (int i = 0; i < pursuers_; ++i) {
      const Vec3<Real> offset = position(env, i) - evader;
      const Real square = max(squared_norm(offset), Real(0.01));
      away -= offset / square;
      const double aside = i == 0 ? 0.0 : ring_.value();
      goal.set(4 * i, evader + offset * (aside / sqrt(square)));
      goal.set(4 * i + 3, Real(0.0));
    }
    if (!evades_) return;
    const Real urge = max(norm(away), Real(1e-6));
    goal.set(4 * pursuers_, penned(evader + away / urge));
    goal.set(4 * pursuers_ + 3, Real(0.0));
  }

  /// The goal moves with the evader's velocity.
  template <class Real>
  void goal_motion(const EnvView<Real>& env, const State<Real>&, Values<Real> motion) const {
    const Vec3<Real> still{Real(0.0), Real(0.0), Real(0.0)};
    for (int i = 0; i < agents(); ++i) {
      motion.set(6 * i, i < pursuers_ ? env.body(at(pursuers_).body).velocity : still);
      motion.set(6 * i + 3, still);
    }
  }

 private:
  /// Columns of a robot about another one.
  struct Sight {
    Part offset, velocity;
  };
  struct Robot {
    int index, body;
    std::string name;
    int memory = 0;  ///< buffer word: a distance at the last step [m]
    Part place = {}, evades = {};
    MotionParts motion = {};
    std::vector<Sight> others = {};  ///< of an agent: all others, the evader first
  };
  /// Joint result of all pursuers.
  template <class Real>
  struct Moment {
    Real distance{kInfinity};    ///< of the evader from the nearest pursuer [m]
    Real separation{kInfinity};  ///< smallest distance between two pursuers [m]
    PassedLimits<Real> passed;
    MaskOf<Real> low{false};
  };

  int count() const { return static_cast<int>(robots_.size()); }
  /// Robots with observations and rewards; an evader that follows a reference is not one.
  int agents() const { return pursuers_ + (evades_ ? 1 : 0); }
  const Robot& at(int i) const { return robots_[static_cast<std::size_t>(i)]; }
  template <class Real>
  SKYBODY_INLINE Vec3<Real> position(const EnvView<Real>& env, int i) const {
    return env.body(at(i).body).position;
  }

  // --- phases of evaluate() ---------------------------------------------------------------------

  template <class Real>
  SKYBODY_INLINE void observe(const EnvView<Real>& env, int i, const Values<Real>& row) const {
    const Robot& robot = at(i);
    const BodyMotion<Real> body = env.body(robot.body);
    robot.place.set(row, body.position);
    robot.motion.set(row, body);
    if (evades_) robot.evades.set(row, Real(i == pursuers_ ? 1.0 : 0.0));
    for (int k = 0; k < static_cast<int>(robot.others.size()); ++k) {
      const BodyMotion<Real> other = env.body(at(other_of(i, k)).body);
      const Sight& sight = robot.others[static_cast<std::size_t>(k)];
      sight.offset.set(row, other.position - body.position);
      sight.velocity.set(row, other.velocity - body.velocity);
    }
  }

  template <class Real>
  SKYBODY_INLINE void meet(const EnvView<Real>& env, int i, Moment<Real>& now) const {
    const BodyMotion<Real> body = env.body(at(i).body);
    now.distance = min(now.distance, norm(position(env, pursuers_) - body.position));
    now.separation = min(now.separation, separation(env, i));
    now.passed.add(limits_.passed(body));
    now.low = logical_or(now.low, body.position.z < height_min_.value());
  }

  /// Distance of pursuer i from its nearest companion.
  template <class Real>
  SKYBODY_INLINE Real separation(const EnvView<Real>& env, int i) const {
    Real nearest(kInfinity);
    for (int j = 0; j < pursuers_; ++j) {
      if (j != i) nearest = min(nearest, norm(position(env, j) - position(env, i)));
    }
    return nearest;
  }

  /// Whether robot i has failed.
  template <class Real>
  SKYBODY_INLINE MaskOf<Real> fails(const EnvView<Real>& env, int i) const {
    const BodyMotion<Real> body = env.body(at(i).body);
    return logical_or(limits_.passed(body).any(), body.position.z < height_min_.value());
  }

  template <class Real>
  SKYBODY_INLINE Real gain(const EnvView<Real>& env, int i, const Real& distance,
                           const Values<Real>& buffer) const {
    Real before = buffer[at(i).memory];
    const Real gained = progress(env, distance, before);
    buffer.set(at(i).memory, before);
    return gained;
  }

  template <class Real>
  SKYBODY_INLINE Real rate_cost(const EnvView<Real>& env, int i) const {
    return rate_cost_.value() * squared_norm(env.body(at(i).body).angular_velocity);
  }

  /// Pursuer i's own reward.
  template <class Real>
  SKYBODY_INLINE Real pursuit(const EnvView<Real>& env, int i, const MaskOf<Real>& caught,
                              const Values<Real>& buffer) const {
    const Real distance = norm(position(env, pursuers_) - position(env, i));
    const Real nearest = separation(env, i);
    const Real lack = max(Real(0.0), 1.0 - nearest / safe_distance_.value());
    const auto failed = logical_or(fails(env, i), nearest < separation_min_.value());
    return progress_reward_.value() * gain(env, i, distance, buffer) - time_cost_.value() -
           crowd_cost_.value() * lack * lack - rate_cost(env, i) +
           at_end<Real>(failed, caught, 1.0);
  }

  /// The evader's reward: it loses the progress of the nearest pursuer.
  template <class Real>
  SKYBODY_INLINE Real evasion(const EnvView<Real>& env, const Moment<Real>& now,
                              const MaskOf<Real>& caught, const Values<Real>& buffer) const {
    return time_cost_.value() -
           progress_reward_.value() * gain(env, pursuers_, now.distance, buffer) -
           rate_cost(env, pursuers_) + at_end<Real>(fails(env, pursuers_), caught, -1.0);
  }

  /// @param sign  1: a capture is good, -1: it is bad
  template <class Real>
  SKYBODY_INLINE Real at_end(const MaskOf<Real>& failed, const MaskOf<Real>& caught,
                             double sign) const {
    const Real capture = choose(caught, Real(sign * capture_reward_.value()), Real(0.0));
    return choose(failed, Real(failure_reward_.value()), capture);
  }

  template <class Real>
  SKYBODY_INLINE void judge(const EnvView<Real>& env, const Moment<Real>& now,
                            const MaskOf<Real>& caught, Evaluation<Real>& out) const {
    Verdict<Real> verdict(out);
    limits_.judge(verdict, now.passed);
    verdict.fail(ground_failure_, now.low);
    verdict.fail(separation_failure_, now.separation < separation_min_.value());
    if (evades_) verdict.fail(evader_failure_, fails(env, pursuers_));
    verdict.finish(success_, caught);
    if (!out.wants_info()) return;
    evader_info_.set(out.info, now.distance);
    nearest_info_.set(out.info, now.separation);
  }

  /// Within `pen`, at heights that pursuers can reach.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> penned(const Vec3<Real>& p) const {
    const Real side(pen_.value());
    const auto held = [&](const Real& x) { return max(min(x, side), -side); };
    return {held(p.x), held(p.y), max(min(p.z, Real(kPenTop)), Real(kPenFloor))};
  }

  // --- configure() ------------------------------------------------------------------------------

  static constexpr double kPenFloor = 1.0, kPenTop = 3.0;  // [m]

  /// The others of robot i in its own order: the evader first, then pursuers in their named order.
  int other_of(int i, int k) const {
    if (i == pursuers_) return k;
    if (k == 0) return pursuers_;
    return k - 1 < i ? k - 1 : k;
  }

  void add_pursuers(const Setup& setup, int evader) {
    for (int r = 0; r < setup.robots().size(); ++r) {
      if (r == evader) continue;
      const RobotInfo& info = setup.robots()[r];
      if (info.action_count == 0) {
        refuse("robot `", info.name,
               "` takes no action, so that it cannot pursue: give it a controller, such as `ctbr`, "
               "or take it out");
      }
      add_robot(setup, r);
    }
    if (count() > 0) return;
    refuse("there is nobody to pursue `", evader_.value(), "`: a chase needs two robots or more");
  }

  void add_robot(const Setup& setup, int r) {
    const RobotInfo& info = setup.robots()[r];
    robots_.push_back({r, info.first_body, info.name, memory_.take(1)});
  }

  void declare_observation(const Setup& setup, int i) {
    Robot& robot = robots_[static_cast<std::size_t>(i)];
    const RobotParts part(setup, observation_, robot.index, robot.name + ".");
    robot.place = part("position", "m", 3, "position of the base's frame, W");
    robot.motion.declare(part);
    if (evades_) {
      robot.evades =
          part("evades", "", 1, "1: the evader, 0: a pursuer; only if both are agents", 0.0, 1.0);
    }
    for (int k = 0; k < count() - 1; ++k) {
      const std::string of = at(other_of(i, k)).name + ".";
      robot.others.push_back(
          {part(of + "offset", "m", 3, "position of the other - own position, W"),
           part(of + "velocity", "m/s", 3, "velocity of the other - own velocity, W")});
    }
  }

  TextParameter evader_{this, word("evader", "evader", "name of the robot that all others pursue")};
  RealParameter capture_radius_{this, real("capture_radius", "m", 0.5, at_least(1e-3),
                                           "a pursuer nearer than this has caught the evader")};
  RealParameter separation_min_{
      this, real("separation_min", "m", 0.4, at_least(0.0), "two pursuers fail nearer than this")};
  RealParameter height_min_{
      this, real("height_min", "m", 0.2, kAny, "a robot fails below this height (W z)")};
  FlightLimits limits_{this};
  RealParameter progress_reward_{this, real("progress_reward", "1/m", 1.0, at_least(0.0),
                                            "reward per metre of approach to the evader")};
  RealParameter capture_reward_{this,
                                real("capture_reward", "", 5.0, at_least(0.0),
                                     "reward of each pursuer when one has caught the evader")};
  RealParameter time_cost_{this, real("time_cost", "", 0.02, at_least(0.0), "cost per step")};
  RealParameter safe_distance_{this, real("safe_distance", "m", 0.8, at_least(1e-3),
                                          "pursuers nearer to one another than this pay a cost")};
  RealParameter crowd_cost_{
      this, real("crowd_cost", "", 0.2, at_least(0.0),
                 "cost at 0 m from another pursuer; quadratic up to `safe_distance`")};
  RealParameter rate_cost_{this, real("rate_cost", "s^2/rad^2", 0.001, at_least(0.0),
                                      "cost per squared angular velocity")};
  RealParameter failure_reward_{
      this, real("failure_reward", "", -5.0, at_most(0.0), "reward of the robots that fail")};
  RealParameter ring_{
      this, real("ring", "m", 1.0, at_least(0.0),
                 "distance from the evader of the baseline's goals, except for the first pursuer")};
  RealParameter pen_{this, real("pen", "m", 3.0, at_least(0.0),
                                "the baseline's evader keeps x and y within this (W)")};

  ObservationParts observation_;
  InfoParts infos_;
  BufferPlan memory_;
  Part evader_info_, nearest_info_;
  Part ground_failure_, separation_failure_, evader_failure_, success_;
  std::vector<Robot> robots_;  ///< pursuers in the scenario's order, then the evader
  int pursuers_ = 0;
  bool evades_ = false;  ///< the evader is an agent
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Chase, "chase", "1.0.0", "Pursuers catch an evader.");
