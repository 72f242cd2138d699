// Race through gates, alone or against others.
#include <skybody/task_kit.h>

#include <string>
#include <vector>

#include "tasks/racing/progress.h"
#include "tasks/racing/track.h"

namespace skybody {
namespace {

using namespace task_kit;
using racing::Gate;
using racing::Passage;
using racing::RaceState;

class Racing : public Task {
 public:
  void configure(const Setup& setup) override {
    track_.configure(setup, gates_.values(), laps_.value() > 1 || first_gate_.value() != 0.0,
                     limits_.bound());
    check_first_gate();
    track_.require_above(height_min_.value());
    track_.require_wide(radius_.value());
    step_time_ = setup.dt() * setup.action_repeat();
    add_racers(setup);
    check_rivals();
    if (racers_.size() > 1) setup.robot_rewards();
    limits_.configure(setup, infos_);
    missed_failure_ =
        declare_failure(setup, infos_, "missed", "crossed a gate's plane beside its opening");
    collision_failure_ =
        declare_failure(setup, infos_, "collision",
                        "nearer than `radius` to a frame, or than twice that to another robot");
    ground_failure_ = declare_failure(setup, infos_, "ground", "below `height_min`");
    success_ = declare_success(setup, infos_, "a racer has flown all `laps`, which ends the race");
    setup.buffer(memory_.size());
    setup.scratch(2 * count());
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out,
                Values<Real> buffer) const {
    const Values<Real> scratch = env.scratch();
    Failures<Real> failures;
    for (int i = 0; i < count(); ++i) race(env, i, buffer, scratch, failures);
    for (int i = 0; i < count(); ++i) observe(env, i, buffer, out);
    reward(scratch, out);
    judge(env, buffer, failures, out);
  }

  template <class Real>
  void goal(const EnvView<Real>& env, const State<Real>&, Values<Real> goal,
            Values<Real> buffer) const {
    for (int i = 0; i < count(); ++i) {
      goal.set(4 * i, led(env, i, buffer).position);
      goal.set(4 * i + 3, yaw(env.body(at(i).body).rotation));  // the goal has no own heading
    }
  }

  template <class Real>
  void goal_motion(const EnvView<Real>& env, const State<Real>&, Values<Real> motion,
                   Values<Real> buffer) const {
    const Vec3<Real> steady{Real(0.0), Real(0.0), Real(0.0)};
    for (int i = 0; i < count(); ++i) {
      motion.set(6 * i, led(env, i, buffer).velocity);
      motion.set(6 * i + 3, steady);
    }
  }

 private:
  /// Columns of a racer about another racer.
  struct Sight {
    Part offset, velocity, lead;
  };
  struct Racer {
    int index, body;
    ActionPart action;
    racing::PastWords past = {};
    Part gate = {}, normal = {}, next_gate = {}, next_normal = {}, velocity = {}, up = {},
         angular_velocity = {};
    std::vector<Sight> others = {};  ///< in the order of racers_, without the racer itself
    Part gates_info = {}, lap_info = {}, speed_info = {};
  };
  template <class Real>
  struct Failures {
    PassedLimits<Real> limits;
    MaskOf<Real> missed{false}, collision{false}, ground{false};
  };

  int count() const { return static_cast<int>(racers_.size()); }
  const Racer& at(int i) const { return racers_[static_cast<std::size_t>(i)]; }

  // --- phases of evaluate() ---------------------------------------------------------------------

  /// Advances racer i along the track; writes its progress and its other rewards to `scratch`.
  template <class Real>
  SKYBODY_INLINE void race(const EnvView<Real>& env, int i, const Values<Real>& buffer,
                           const Values<Real>& scratch, Failures<Real>& failures) const {
    const Racer& racer = at(i);
    const BodyMotion<Real> body = env.body(racer.body);
    RaceState<Real> past = racer.past.load(buffer);
    const Real time = to_real(env.step()) * step_time_;
    const Passage<Real> way = advance(env, track_, first_gate_(env), time, body.position, past);
    racer.past.store(buffer, past);
    const PassedLimits<Real> limits = limits_.passed(body);
    const MaskOf<Real> collision = collides(env, i, body.position);
    const MaskOf<Real> ground = body.position.z < height_min_.value();
    const MaskOf<Real> failed =
        logical_or(logical_or(limits.any(), way.missed), logical_or(collision, ground));
    scratch.set(2 * i, progress_reward_.value() * way.gain);
    scratch.set(2 * i + 1, select(way.passed, Real(gate_reward_.value()), Real(0.0)) -
                               rate_cost_.value() * squared_norm(body.angular_velocity) +
                               select(failed, Real(failure_reward_.value()), Real(0.0)));
    failures.limits.add(limits);
    failures.missed = logical_or(failures.missed, way.missed);
    failures.collision = logical_or(failures.collision, collision);
    failures.ground = logical_or(failures.ground, ground);
  }

  template <class Real>
  SKYBODY_INLINE MaskOf<Real> collides(const EnvView<Real>& env, int i, const Vec3<Real>& p) const {
    const double radius = radius_.value();
    MaskOf<Real> hits = track_.frame_distance(env, p) < radius;
    for (int j = 0; j < count(); ++j) {
      if (j == i) continue;
      const Vec3<Real> offset = env.body(at(j).body).position - p;
      hits = logical_or(hits, squared_norm(offset) < 4.0 * radius * radius);
    }
    return hits;
  }

  template <class Real>
  SKYBODY_INLINE void observe(const EnvView<Real>& env, int i, const Values<Real>& buffer,
                              const Evaluation<Real>& out) const {
    const Racer& racer = at(i);
    const BodyMotion<Real> body = env.body(racer.body);
    const auto in_body = [&](const Vec3<Real>& v) { return rotate_inverse(body.rotation, v); };
    const RaceState<Real> past = racer.past.load(buffer);
    const Real index = first_gate_(env) + past.gates;
    const Gate<Real> gate = track_.at(env, index), next = track_.at(env, index + 1.0);
    const Values<Real>& row = out.observation;
    racer.gate.set(row, in_body(gate.centre - body.position));
    racer.normal.set(row, in_body(gate.normal()));
    racer.next_gate.set(row, in_body(next.centre - body.position));
    racer.next_normal.set(row, in_body(next.normal()));
    racer.velocity.set(row, in_body(body.velocity));
    racer.up.set(row, in_body(Vec3<Real>{Real(0.0), Real(0.0), Real(1.0)}));
    racer.angular_velocity.set(row, body.angular_velocity);
    racer.action.set(env, row);
    for (int j = 0; j < count(); ++j) {
      if (j == i) continue;
      const Sight& sight = racer.others[static_cast<std::size_t>(j < i ? j : j - 1)];
      const BodyMotion<Real> other = env.body(at(j).body);
      sight.offset.set(row, in_body(other.position - body.position));
      sight.velocity.set(row, in_body(other.velocity - body.velocity));
      sight.lead.set(row, at(j).past.gates(buffer) - past.gates);
    }
    if (!out.wants_info()) return;
    racer.gates_info.set(out.info, past.gates);
    racer.lap_info.set(out.info, past.lap_time);
    racer.speed_info.set(out.info, norm(body.velocity));
  }

  /// Each racer's reward, minus a share of the others' progress; the mean is the environment's
  /// reward.
  template <class Real>
  SKYBODY_INLINE void reward(const Values<Real>& scratch, Evaluation<Real>& out) const {
    Real gains(0.0), sum(0.0);
    for (int i = 0; i < count(); ++i) gains += scratch[2 * i];
    for (int i = 0; i < count(); ++i) {
      Real own = scratch[2 * i] + scratch[2 * i + 1];
      if (count() > 1) {
        const double share = rivalry_.value() / static_cast<double>(count() - 1);
        own = own - share * (gains - scratch[2 * i]);
        out.set_reward(at(i).index, own);
      }
      sum += own;
    }
    out.set_reward(sum / static_cast<double>(count()));
  }

  template <class Real>
  SKYBODY_INLINE void judge(const EnvView<Real>&, const Values<Real>& buffer,
                            const Failures<Real>& failures, Evaluation<Real>& out) const {
    Real most(0.0);
    for (const Racer& racer : racers_) most = max(most, racer.past.gates(buffer));
    Verdict<Real> verdict(out);
    limits_.judge(verdict, failures.limits);
    verdict.fail(missed_failure_, failures.missed);
    verdict.fail(collision_failure_, failures.collision);
    verdict.fail(ground_failure_, failures.ground);
    verdict.finish(success_, most >= static_cast<double>(laps_.value() * track_.size()));
  }

  template <class Real>
  SKYBODY_INLINE racing::Lead<Real> led(const EnvView<Real>& env, int i,
                                        const Values<Real>& buffer) const {
    const Gate<Real> gate = track_.at(env, first_gate_(env) + at(i).past.gates(buffer));
    const double lane = (i - 0.5 * (count() - 1)) * lane_width_.value();
    return racing::lead(gate, env.body(at(i).body).position, pace_.value(), lane);
  }

  // --- configure() ------------------------------------------------------------------------------

  void check_first_gate() const {
    const double first = first_gate_.value();
    if (first == floor(first) && first < track_.size()) return;
    refuse("`first_gate` is ", first, "; allowed: whole numbers from 0 to ", track_.size() - 1);
  }

  /// Checks that parameters for several racers fit their number and the gates.
  void check_rivals() const {
    if (racers_.size() < 2 && rivalry_.value() > 0.0) {
      refuse("`rivalry` is ", rivalry_.value(),
             ", and there is one racer: add a robot that takes actions, or take 0");
    }
    if (lane_width_.is_given()) {
      track_.require_lanes(lane_width_.value(), static_cast<int>(racers_.size()), radius_.value());
    }
  }

  void add_racers(const Setup& setup) {
    std::vector<int> robots;
    for (const std::string& name : robots_.values()) robots.push_back(setup.robot(name));
    if (robots.empty()) {
      for (int r = 0; r < setup.robots().size(); ++r) {
        if (setup.robots()[r].action_count > 0) robots.push_back(r);
      }
    }
    if (robots.empty()) {
      refuse(
          "no robot takes actions, so that none can race: give one a controller, such as `ctbr`");
    }
    for (std::size_t i = 0; i < robots.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (robots[i] != robots[j]) continue;
        refuse("robot `", setup.robots()[robots[i]].name, "` is named twice: name each racer once");
      }
      declare(setup, robots[i], robots);
    }
  }

  void declare(const Setup& setup, int index, const std::vector<int>& robots) {
    const RobotInfo& info = setup.robots()[index];
    const std::string prefix = robots.size() > 1 ? std::string(info.name) + "." : "";
    const RobotParts part(setup, observation_, index, prefix);
    Racer racer{index, info.first_body, ActionPart(info, "racing")};
    racer.past = racing::PastWords(memory_);
    racer.gate = part("gate", "m", 3, "centre of the next gate - position, B");
    racer.normal = part("gate_normal", "", 3, "unit vector through that gate, B", 1.0);
    racer.next_gate = part("following_gate", "m", 3, "centre of the following gate - position, B");
    racer.next_normal = part("following_normal", "", 3, "unit vector through that gate, B", 1.0);
    racer.velocity = part("velocity", "m/s", 3, "velocity of the base's frame, B");
    racer.up = part("up", "", 3, "z axis of W, B: the attitude without the heading", 1.0);
    racer.angular_velocity =
        part("angular_velocity", "rad/s", 3, "angular velocity of the base, B");
    racer.action.declare(part);
    for (const int other : robots) {
      if (other == index) continue;
      const std::string of = std::string(setup.robots()[other].name) + ".";
      racer.others.push_back(
          {part(of + "offset", "m", 3, "position of the other - own position, B"),
           part(of + "velocity", "m/s", 3, "velocity of the other - own velocity, B"),
           part(of + "lead", "", 1, "gates passed by the other - own gates")});
    }
    racer.gates_info =
        infos_.add(setup, prefix + "gates_passed", "", "gates passed in this episode");
    racer.lap_info =
        infos_.add(setup, prefix + "lap_time", "s",
                   "time of the last whole lap, the first one from the reset; 0: none yet");
    racer.speed_info = infos_.add(setup, prefix + "speed", "m/s", "speed of the base's frame");
    racers_.push_back(racer);
    setup.goal(index, info.first_body);
  }

  TextsParameter robots_{
      this, words("robots", "names of the racers; empty: all robots that take actions")};
  TextsParameter gates_{this, words("gates",
                                    "obstacles of kind `gate` in the order of the track; empty: "
                                    "all, in the scenario's order")};
  IntegerParameter laps_{this,
                         integer("laps", "", 1, between(1, 1000), "number of laps of the race")};
  RealParameter first_gate_{
      this,
      randomizable(real("first_gate", "", 0.0, between(0.0, 1000.0),
                        "index of the first gate, from 0; a lap ends with the gate before it"))};
  RealParameter radius_{this, real("radius", "m", 0.2, between(0.0, 100.0),
                                   "radius of a robot: it collides if nearer than this to a frame, "
                                   "or than twice this to another robot")};
  RealParameter height_min_{
      this, real("height_min", "m", 0.1, kAny, "a robot fails below this height (W z)")};
  FlightLimits limits_{this};
  RealParameter progress_reward_{this,
                                 real("progress_reward", "1/m", 1.0, at_least(0.0),
                                      "reward per metre of approach to the next gate's centre")};
  RealParameter gate_reward_{this,
                             real("gate_reward", "", 1.0, at_least(0.0), "reward per passed gate")};
  RealParameter rate_cost_{this, real("rate_cost", "s^2/rad^2", 0.0005, at_least(0.0),
                                      "cost per squared angular velocity")};
  RealParameter failure_reward_{
      this, real("failure_reward", "", -10.0, at_most(0.0), "reward added for a robot that fails")};
  RealParameter rivalry_{
      this, real("rivalry", "", 0.0, between(0.0, 1.0),
                 "share of the others' progress reward, subtracted from a racer's reward")};
  RealParameter pace_{this, real("pace", "m/s", 2.0, between(0.01, 100.0),
                                 "speed of the goals through gates, for the baseline `hold`")};

  RealParameter lane_width_{this, real("lane_width", "m", 0.8, between(0.0, 100.0),
                                       "distance between the lanes of several racers' goals")};

  ObservationParts observation_;
  InfoParts infos_;
  BufferPlan memory_;
  Part missed_failure_, collision_failure_, ground_failure_, success_;
  racing::Track track_;
  std::vector<Racer> racers_;
  double step_time_ = 0.0;  ///< duration of an action [s]
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Racing, "racing", "1.0.0", "Race through gates, alone or against others.");
