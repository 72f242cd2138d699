// The paper's formation task: N robots hover on a polygon about a target, level and facing forward,
// and clear of obstacles if the scenario has any.
#include <skybody/task_kit.h>

#include <vector>

#include "tasks/formation/polygon.h"

namespace skybody {
namespace {

using namespace task_kit;

class Formation : public Task {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    target_.configure(setup);
    add_robots(setup);
    set_places();
    obstacles_.configure(setup, "formation");
    is_shaped_ = shaping_.is_asked_for() || failure_reward_.value() != 0.0;
    tilt_cosine_ = tilt_cosine_limit(tilt_max_.value());
    farthest_ = distance_max_.value() > 0.0 ? distance_max_.value() : kInfinity;
    for (int i = 0; i < count(); ++i) declare_observation(setup, i);
    repeat_motion(setup);
    for (const Robot& robot : robots_) setup.goal(robot.index, robot.body);
    setup.robot_rewards();
    error_info_ =
        infos_.add(setup, "formation_error", "m",
                   "Hausdorff distance of the robots from the places about their centroid");
    centroid_info_ =
        infos_.add(setup, "centroid_error", "m", "distance of the centroid from the target");
    nearest_info_ =
        infos_.add(setup, "nearest_distance", "m", "smallest distance between two robots");
    tilt_failure_ = declare_failure(setup, infos_, "tilt", "a robot beyond `tilt_max`");
    distance_failure_ = declare_failure(setup, infos_, "distance", "a robot beyond `distance_max`");
    separation_failure_ =
        declare_failure(setup, infos_, "separation", "two robots closer than `separation_min`");
    if (obstacles_.count() > 0) {
      setup.need_contacts();
      collision_failure_ = declare_failure(
          setup, infos_, "collision", "a robot touches an obstacle, the ground or another robot");
    }
    success_ = declare_success(setup, infos_, "`formation_error` is below `success_error`");
  }

  /// Draws a target in the box, unless the scenario gives one.
  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>&, Start<Real>& start) const {
    if (!target_.is_drawn()) return;
    Random<Real> draw = random(env);
    Vec3<Real> target = target_.draw_point(draw);
    if (relative_.value()) target += env.body(robots_[0].body).position;
    target.z = max(target.z, Real(min_height_.value()));
    target_.place(target, start);
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out) const {
    const Vec3<Real> target = target_.position(env);
    observe(env, target, out.observation);
    const Vec3<Real> centroid = centroid_of(env);
    const Real centroid_error = norm(centroid - target);
    const Real arrival = exp(-centroid_error);
    Real nearest(kInfinity), forward(0.0);
    Real clear(kInfinity), terms(0.0);
    Failures<Real> failed;
    for (int i = 0; i < count(); ++i) {
      const BodyMotion<Real> body = motion(env, i);
      const Real own_nearest = nearest_distance<Real>(out.observation, i);
      const Real own_clear = min(
          own_nearest, obstacles_.observe(env, body.position, at(i).obstacles, out.observation));
      const Real own_error = norm(body.position - centroid - place<Real>(i));
      const Real own_forward = forward_cosine(body.rotation);
      const Failures<Real> own_failed = failures_of(env, i, body, target, own_nearest);
      const Real own_terms = shaping_of(i, body, target, own_failed.any());
      out.set_reward(at(i).index, reward(own_clear, own_error, arrival, own_forward) + own_terms);
      nearest = min(nearest, own_nearest);
      clear = min(clear, own_clear);
      forward += own_forward;
      terms += own_terms;
      failed.add(own_failed);
    }
    const double share = 1.0 / static_cast<double>(count());
    const Real error = formation_error(env, centroid);
    out.set_reward(reward(clear, error, arrival, forward / static_cast<double>(count())) +
                   terms * share);
    Verdict<Real> verdict(out);
    verdict.fail(tilt_failure_, failed.tilt);
    verdict.fail(distance_failure_, failed.distance);
    verdict.fail(separation_failure_, failed.separation);
    if (obstacles_.count() > 0) verdict.fail(collision_failure_, failed.collision);
    verdict.succeed(success_, error < success_error_.value());
    error_info_.set(out.info, error);
    centroid_info_.set(out.info, centroid_error);
    nearest_info_.set(out.info, nearest);
  }

  template <class Real>
  void goal(const EnvView<Real>& env, const State<Real>&, Values<Real> goal) const {
    const double storey = min(kStorey, kStoreys / count());
    for (int i = 0; i < count(); ++i) {
      const Vec3<Real> own = target_.position(env) + place<Real>(i);
      const Vec3<Real> way = own - env.body(at(i).body).position;
      // Goals approach at different heights, increasing with the robot's index, so that two robots
      // do not meet on the way.
      const Real far =
          clamp((norm(way.x, way.y) - kSinkTo) / (kSinkFrom - kSinkTo), Real(0.0), Real(1.0));
      goal.set(4 * i, own + Vec3<Real>{Real(0.0), Real(0.0), far * (storey * i)});
      goal.set(4 * i + 3, Real(0.0));
    }
  }

 private:
  static constexpr double kErrorWeight = 2.56;  // (1.6)^2 [1/m^2]
  // [m] a smaller distance of neighbours costs reward
  static constexpr double kSafeDistance = 0.5;
  static constexpr double kArrivalReward = 0.4;  // for closeness without the formation
  // Goals of the baseline: height between consecutive robots' goals, the largest height, and the
  // distances from its place [m] at which a goal starts and ends sinking.
  static constexpr double kStorey = 0.5, kStoreys = 5.0, kSinkFrom = 2.0, kSinkTo = 0.5;

  /// Columns of a robot about another one: the first index of each, and their sizes.
  enum Sight { kOffset = 0, kDistance = 3, kVelocity = 4, kRotation = 7, kSight = 16 };
  /// Limits that a robot violates.
  template <class Real>
  struct Failures {
    MaskOf<Real> tilt{false}, distance{false}, separation{false}, collision{false};

    SKYBODY_INLINE MaskOf<Real> any() const {
      return logical_or(logical_or(tilt, distance), logical_or(separation, collision));
    }
    SKYBODY_INLINE void add(const Failures& other) {
      tilt = logical_or(tilt, other.tilt);
      distance = logical_or(distance, other.distance);
      separation = logical_or(separation, other.separation);
      collision = logical_or(collision, other.collision);
    }
  };
  struct Robot {
    int index, body, body_count;
    std::string name;
    Vec3<double> place = {};  ///< relative to the target [m]
    Part target_error = {}, velocity = {}, rotation = {}, angular_velocity = {};
    Part others = {};  ///< a Sight of each, in the order of robots_, without the robot itself
    Part place_error = {};
    ObstacleParts obstacles = {};
  };

  int count() const { return static_cast<int>(robots_.size()); }
  /// Index in `others` of robot i of its Sight of robot j.
  static int sight(int i, int j) { return kSight * (j < i ? j : j - 1); }
  const Robot& at(int i) const { return robots_[static_cast<std::size_t>(i)]; }

  void add_robots(const Setup& setup) {
    if (setup.robots().size() < 2) {
      refuse(
          "a formation needs two robots or more, and there is 1: add robots, or take task `hover`");
    }
    for (int r = 0; r < setup.robots().size(); ++r) {
      const RobotInfo& info = setup.robots()[r];
      if (info.action_count == 0) {
        refuse("robot `", info.name,
               "` takes no action, so that it cannot fly to its place: give it a controller, such "
               "as `rotor_speed`, that no team feeds");
      }
      robots_.push_back({r, info.first_body, info.body_count, info.name});
    }
  }

  void set_places() {
    const std::vector<Vec3<double>> places = polygon_places(count(), radius_.value());
    for (std::size_t i = 0; i < robots_.size(); ++i) robots_[i].place = places[i];
  }

  void declare_observation(const Setup& setup, int i) {
    Robot& robot = robots_[static_cast<std::size_t>(i)];
    const RobotParts part(setup, observation_, robot.index, robot.name + ".");
    robot.target_error = part("target_error", "m", 3, "target - position, W");
    robot.velocity = part("velocity", "m/s", 3, "velocity of the base's frame, W");
    robot.rotation = part("rotation", "", 9, "matrix W from B, row by row", 1.0);
    robot.angular_velocity =
        part("angular_velocity", "rad/s", 3, "angular velocity of the base, B");
    robot.others = Part(observation_.size(), kSight * (count() - 1), "others");
    for (const Robot& other : robots_) {
      if (other.index == robot.index) continue;
      const std::string of = other.name + ".";
      part(of + "offset", "m", 3, "position of the other - own position, W");
      part(of + "distance", "m", 1, "length of the offset", 0.0, kInfinity);
      part(of + "velocity", "m/s", 3, "velocity of the other, W");
      part(of + "rotation", "", 9, "rotation of the other: matrix W from its axes, row by row",
           1.0);
    }
    if (sees_place_.value()) {
      robot.place_error = part("place_error", "m", 3, "target + own place - position, W");
    }
    robot.obstacles = obstacles_.declare(setup, observation_, robot.name + ".", robot.index);
  }

  /// All others observe the same values of a robot's motion.
  void repeat_motion(const Setup& setup) {
    for (int i = 0; i < count(); ++i) {
      for (int j = 0; j < count(); ++j) {
        if (i == j) continue;
        const int to = at(i).others.first() + sight(i, j);
        setup.repeat(to + kVelocity, at(j).velocity.first(), 3);
        setup.repeat(to + kRotation, at(j).rotation.first(), 9);
      }
    }
  }

  template <class Real>
  SKYBODY_INLINE BodyMotion<Real> motion(const EnvView<Real>& env, int i) const {
    return env.body(at(i).body);
  }

  template <class Real>
  SKYBODY_INLINE Vec3<Real> place(int i) const {
    const Vec3<double>& p = at(i).place;
    return {Real(p.x), Real(p.y), Real(p.z)};
  }

  template <class Real>
  void observe(const EnvView<Real>& env, const Vec3<Real>& target, Values<Real> row) const {
    for (int j = 0; j < count(); ++j) {
      const BodyMotion<Real> seen = motion(env, j);
      const Mat3<Real> rotation = to_mat3(seen.rotation);
      at(j).target_error.set(row, target - seen.position);
      at(j).velocity.set(row, seen.velocity);
      at(j).rotation.set(row, rotation);
      at(j).angular_velocity.set(row, seen.angular_velocity);
      if (sees_place_.value()) {
        at(j).place_error.set(row, target + place<Real>(j) - seen.position);
      }
      if constexpr (!kLeavesRepeats<Real>) {
        for (int i = 0; i < count(); ++i) {
          if (i == j) continue;
          at(i).others.set(row, seen.velocity, sight(i, j) + kVelocity);
          at(i).others.set(row, rotation, sight(i, j) + kRotation);
        }
      }
      for (int i = 0; i < j; ++i) observe_pair(env, i, j, seen.position, row);
    }
  }

  /// Values of a pair of robots about each other.
  template <class Real>
  SKYBODY_INLINE void observe_pair(const EnvView<Real>& env, int i, int j, const Vec3<Real>& there,
                                   const Values<Real>& row) const {
    const Vec3<Real> here = motion(env, i).position, offset = there - here;
    const Real distance = norm(offset);
    at(i).others.set(row, offset, sight(i, j) + kOffset);
    at(i).others.set(row, distance, sight(i, j) + kDistance);
    at(j).others.set(row, here - there, sight(j, i) + kOffset);
    at(j).others.set(row, distance, sight(j, i) + kDistance);
  }

  /// x of the body's x axis: 1 facing along W's x, level.
  template <class Real>
  static SKYBODY_INLINE Real forward_cosine(const Quat<Real>& q) {
    return to_mat3(q)(0, 0);
  }

  template <class Real>
  SKYBODY_INLINE Vec3<Real> centroid_of(const EnvView<Real>& env) const {
    Vec3<Real> sum = motion(env, 0).position;
    for (int i = 1; i < count(); ++i) sum += motion(env, i).position;
    return sum / Real(static_cast<double>(count()));
  }

  /// Distance of robot i from any other robot, as observed.
  template <class Real>
  SKYBODY_INLINE Real nearest_distance(const Values<Real>& observation, int i) const {
    Real nearest(kInfinity);
    const Part& others = at(i).others;
    for (int k = kDistance; k < others.count(); k += kSight) {
      nearest = min(nearest, observation[others.first() + k]);
    }
    return nearest;
  }

  template <class Real>
  SKYBODY_INLINE Real formation_error(const EnvView<Real>& env, const Vec3<Real>& centroid) const {
    return hausdorff_distance<Real>(
        count(), [&](int i) { return motion(env, i).position - centroid; },
        [&](int i) { return place<Real>(i); });
  }

  template <class Real>
  SKYBODY_INLINE Failures<Real> failures_of(const EnvView<Real>& env, int i,
                                            const BodyMotion<Real>& body, const Vec3<Real>& target,
                                            const Real& nearest) const {
    Failures<Real> failed;
    failed.tilt = tilt_cosine(body.rotation) < tilt_cosine_;
    failed.distance = norm(body.position - target) > farthest_;
    failed.separation = nearest < separation_min_.value();
    if (obstacles_.count() == 0) return failed;
    for (int b = 0; b < at(i).body_count; ++b) {
      failed.collision = logical_or(failed.collision, env.contact(at(i).body + b).touching);
    }
    return failed;
  }

  /// Shaping terms beyond the paper's reward, about the robot's own place in the world.
  template <class Real>
  SKYBODY_INLINE Real shaping_of(int i, const BodyMotion<Real>& body, const Vec3<Real>& target,
                                 const MaskOf<Real>& failed) const {
    if (!is_shaped_) return Real(0.0);
    const Real distance = norm(target + place<Real>(i) - body.position);
    return shaping_.reward(distance, yaw(body.rotation)) - shaping_.cost(body.rotation) +
           select(failed, Real(failure_reward_.value()), Real(0.0));
  }

  /// s (f + f (g + h) + 0.4 g): see README.
  template <class Real>
  static SKYBODY_INLINE Real reward(const Real& nearest, const Real& error, const Real& arrival,
                                    const Real& forward) {
    const Real ratio = nearest / kSafeDistance;
    const Real separation = min(ratio * ratio, Real(1.0));
    const Real formation = closeness(error * error, kErrorWeight);
    return separation * (formation + formation * (arrival + forward) + kArrivalReward * arrival);
  }

  RealParameter radius_{this, real("radius", "m", 1.0, at_least(0.01),
                                   "radius of the polygon with the robots' places at its corners")};
  DrawnTarget target_{this,
                      {.target = {0.0, 0.0, 1.5},
                       .low = {-2.0, -2.0, -2.0},
                       .high = {2.0, 2.0, -0.5},
                       .low_doc = "lower corner of the box of random targets, see `relative`",
                       .high_doc = "upper corner of the box of random targets, see `relative`"}};
  BooleanParameter relative_{
      this,
      boolean("relative", true,
              "the box of random targets is relative to the first robot's start; false: to W")};
  RealParameter min_height_{
      this, real("min_height", "m", 1.0, kAny, "least height of a random target (W z)")};
  RealParameter separation_min_{
      this, real("separation_min", "m", 0.0, at_least(0.0),
                 "an episode terminates if two robots are closer than this; 0: never")};
  RealParameter tilt_max_{this,
                          real("tilt_max", "rad", kPi, between(0.0, kPi),
                               "an episode terminates if a robot tilts more than this; pi: never")};
  RealParameter distance_max_{
      this,
      real("distance_max", "m", 0.0, at_least(0.0),
           "an episode terminates if a robot is farther than this from the target; 0: never")};
  BooleanParameter sees_place_{this,
                               boolean("sees_place", false,
                                       "each robot observes the vector to its own place; with one "
                                       "policy for all, no other column identifies it")};
  NearestObstacles obstacles_{this};
  GoalShaping shaping_{this};
  RealParameter failure_reward_{
      this, real("failure_reward", "", 0.0, at_most(0.0),
                 "added if an episode terminates, for a robot that has failed")};

  RealParameter success_error_{
      this, real("success_error", "m", 0.3, at_least(0.0),
                 "the formation is complete below this `formation_error` (info `success`)")};

  ObservationParts observation_;
  InfoParts infos_;
  Part error_info_, centroid_info_, nearest_info_;
  Part tilt_failure_, distance_failure_, separation_failure_, collision_failure_, success_;
  bool is_shaped_ = false;  ///< whether there are terms beyond the paper's reward
  std::vector<Robot> robots_;
  double tilt_cosine_ = -2.0, farthest_ = kInfinity;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Formation, "formation", "1.0.0",
               "Several robots hover on a polygon about a target.");
