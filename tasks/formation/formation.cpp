// The paper's formation task: N robots stand on a polygon about a target, level and facing forward.
#include <vector>

#include "tasks/common/flight.h"

namespace skybody {
namespace {

class Formation : public Task {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    flight::require_box(target_min_, target_max_);
    drawn_target_ = flight::announce_drawn(setup, target_);
    add_robots(setup);
    set_places();
    tilt_cosine_ = flight::tilt_cosine_limit(tilt_max_.value());
    farthest_ = distance_max_.value() > 0.0 ? distance_max_.value() : kInfinity;
    for (int i = 0; i < count(); ++i) declare_observation(setup, i);
    for (const Robot& robot : robots_) setup.goal(robot.index, robot.body);
    setup.robot_rewards();
    setup.info("formation_error", "m", 1);
    setup.info("centroid_error", "m", 1);
    setup.info("nearest_distance", "m", 1);
  }

  /// A target in the box, unless the scenario gives one.
  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>&, Start<Real>& start) const {
    if (drawn_target_ < 0) return;
    Random<Real> draw = random(env);
    Real drawn[3];
    for (int k = 0; k < 3; ++k)
      drawn[k] = draw.uniform(Real(target_min_.value(k)), Real(target_max_.value(k)));
    Vec3<Real> target{drawn[0], drawn[1], drawn[2]};
    if (relative_.value()) target += env.body(robots_[0].body).position;
    target.z = max(target.z, Real(min_height_.value()));
    start.params.set(drawn_target_, target);
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out) const {
    const Vec3<Real> target = target_.vec3(env);
    observe(env, target, out.observation);
    const Vec3<Real> centroid = centroid_of(env);
    const Real centroid_error = norm(centroid - target);
    const Real arrival = exp(-centroid_error);
    Real nearest(kInfinity), forward(0.0);
    MaskOf<Real> failed(false);
    for (int i = 0; i < count(); ++i) {
      const BodyMotion<Real> body = motion(env, i);
      const Real own_nearest = nearest_distance<Real>(out.observation, i);
      const Real own_error = norm(body.position - centroid - place<Real>(i));
      const Real own_forward = forward_cosine(body.rotation);
      out.set_reward(at(i).index, reward(own_nearest, own_error, arrival, own_forward));
      nearest = min(nearest, own_nearest);
      forward += own_forward;
      failed = logical_or(failed, left(body, target));
    }
    const Real error = hausdorff_distance(env, centroid);
    out.set_reward(reward(nearest, error, arrival, forward / static_cast<double>(count())));
    out.terminate(logical_or(failed, nearest < separation_min_.value()));
    out.info.set(0, error);
    out.info.set(1, centroid_error);
    out.info.set(2, nearest);
  }

  template <class Real>
  void goal(const EnvView<Real>& env, const State<Real>&, Values<Real> goal) const {
    for (int i = 0; i < count(); ++i) {
      goal.set(4 * i, target_.vec3(env) + place<Real>(i));
      goal.set(4 * i + 3, Real(0.0));
    }
  }

 private:
  static constexpr int kSelf = 18, kOther = 16;  // values of the observation
  static constexpr int kDistance = 3;            // among those of another robot
  static constexpr int kCentered = 5;            // robots from which on one stands in the centre
  static constexpr double kErrorWeight = 2.56;   // (1.6)^2 [1/m^2]
  static constexpr double kSafeDistance = 0.5;   // [m] below, neighbours cost reward
  static constexpr double kArrivalReward = 0.4;  // for being near without the formation

  struct Robot {
    int index, body;
    std::string name;
    Vec3<double> place;  ///< from the target [m]
  };

  int count() const { return static_cast<int>(robots_.size()); }
  /// Where the observation has what robot i sees of its n-th other one.
  int seen_by(int i, int n) const {
    return (kSelf + kOther * (count() - 1)) * i + kSelf + kOther * n;
  }
  const Robot& at(int i) const { return robots_[static_cast<std::size_t>(i)]; }

  void add_robots(const Setup& setup) {
    if (setup.robots().size() < 2) {
      throw std::runtime_error(
          "a formation needs two robots or more, and there is 1: add robots, "
          "or take task `hover`");
    }
    for (int r = 0; r < setup.robots().size(); ++r) {
      const RobotInfo& info = setup.robots()[r];
      if (info.action_count == 0) {
        throw std::runtime_error("robot `" + std::string(info.name) +
                                 "` takes no action, so that it cannot fly to its place: give it a "
                                 "controller, such as `rotor_speed`, that no team feeds");
      }
      robots_.push_back({r, info.first_body, info.name, {}});
    }
  }

  /// Regular polygon in the horizontal plane, the first corner along +x, counter-clockwise; from
  /// five robots on the first stands in its centre. The places' mean is the target.
  void set_places() {
    const int center = count() >= kCentered ? 1 : 0;
    const int corners = count() - center;
    for (int i = center; i < count(); ++i) {
      const SinCos<double> angle = sincos(kTwoPi * (i - center) / corners);
      robots_[static_cast<std::size_t>(i)].place = {radius_.value() * angle.cos,
                                                    radius_.value() * angle.sin, 0.0};
    }
  }

  void declare_observation(const Setup& setup, int i) const {
    const std::string self = at(i).name + ".";
    const int r = at(i).index;
    setup.channel(self + "target_error", "m", 3, -kInfinity, kInfinity, r);
    setup.channel(self + "velocity", "m/s", 3, -kInfinity, kInfinity, r);
    setup.channel(self + "rotation", "", 9, -1.0, 1.0, r);
    setup.channel(self + "angular_velocity", "rad/s", 3, -kInfinity, kInfinity, r);
    for (const Robot& other : robots_) {
      if (other.index == r) continue;
      const std::string prefix = self + other.name + ".";
      setup.channel(prefix + "offset", "m", 3, -kInfinity, kInfinity, r);
      setup.channel(prefix + "distance", "m", 1, 0.0, kInfinity, r);
      setup.channel(prefix + "velocity", "m/s", 3, -kInfinity, kInfinity, r);
      setup.channel(prefix + "rotation", "", 9, -1.0, 1.0, r);
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
  void observe(const EnvView<Real>& env, const Vec3<Real>& target, Values<Real> observation) const {
    for (int j = 0; j < count(); ++j) {  // what all others see of it is the same
      const BodyMotion<Real> seen = motion(env, j);
      const Mat3<Real> rotation = to_mat3(seen.rotation);
      const int self = seen_by(j, 0) - kSelf;
      observation.set(self, target - seen.position);
      observation.set(self + 3, seen.velocity);
      set_rotation(observation, self + 6, rotation);
      observation.set(self + 15, seen.angular_velocity);
      for (int i = 0; i < count(); ++i) {
        if (i == j) continue;
        const int k = seen_by(i, j < i ? j : j - 1);
        const Vec3<Real> offset = seen.position - motion(env, i).position;
        observation.set(k, offset);
        observation.set(k + kDistance, norm(offset));
        observation.set(k + 4, seen.velocity);
        set_rotation(observation, k + 7, rotation);
      }
    }
  }

  template <class Real>
  static SKYBODY_INLINE void set_rotation(Values<Real> observation, int k,
                                          const Mat3<Real>& rotation) {
    for (int n = 0; n < 9; ++n) observation.set(k + n, rotation.m[n]);
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

  /// Of robot i from any other, as it has observed them.
  template <class Real>
  SKYBODY_INLINE Real nearest_distance(const Values<Real>& observation, int i) const {
    Real nearest(kInfinity);
    for (int n = 0; n < count() - 1; ++n) {
      nearest = min(nearest, observation[seen_by(i, n) + kDistance]);
    }
    return nearest;
  }

  /// How far any robot is from the closest place, or any place from the closest robot.
  template <class Real>
  SKYBODY_INLINE Real hausdorff_distance(const EnvView<Real>& env,
                                         const Vec3<Real>& centroid) const {
    Real farthest(0.0);
    for (int i = 0; i < count(); ++i) {
      const Vec3<Real> robot = motion(env, i).position - centroid;
      Real to_place(kInfinity), to_robot(kInfinity);
      for (int j = 0; j < count(); ++j) {
        const Vec3<Real> other = motion(env, j).position - centroid;
        to_place = min(to_place, squared_norm(robot - place<Real>(j)));
        to_robot = min(to_robot, squared_norm(other - place<Real>(i)));
      }
      farthest = max(farthest, max(to_place, to_robot));
    }
    return sqrt(farthest);
  }

  /// s (f + f (g + h) + 0.4 g): see README.
  template <class Real>
  static SKYBODY_INLINE Real reward(const Real& nearest, const Real& error, const Real& arrival,
                                    const Real& forward) {
    const Real ratio = nearest / kSafeDistance;
    const Real separation = min(ratio * ratio, Real(1.0));
    const Real formation = flight::closeness(error * error, kErrorWeight);
    return separation * (formation + formation * (arrival + forward) + kArrivalReward * arrival);
  }

  template <class Real>
  SKYBODY_INLINE MaskOf<Real> left(const BodyMotion<Real>& body, const Vec3<Real>& target) const {
    return logical_or(tilt_cosine(body.rotation) < tilt_cosine_,
                      norm(body.position - target) > farthest_);
  }

  RealParameter radius_{this,
                        {.name = "radius",
                         .unit = "m",
                         .value = 1.0,
                         .min = 0.01,
                         .doc = "of the polygon on whose corners the robots belong"}};
  RealsParameter target_{
      this,
      {.name = "target",
       .unit = "m",
       .values = {0.0, 0.0, 1.5},
       .doc = "x, y, z (W); where the scenario gives none, one is drawn for each "
              "episode",
       .randomizable = true}};
  BooleanParameter relative_{this,
                             {.name = "relative",
                              .value = true,
                              .doc = "drawn targets count from where the first robot starts"}};
  RealsParameter target_min_{this,
                             {.name = "target_min",
                              .unit = "m",
                              .values = {-2.0, -2.0, -2.0},
                              .doc = "lower corner of the box of drawn targets (W axes)"}};
  RealsParameter target_max_{this,
                             {.name = "target_max",
                              .unit = "m",
                              .values = {2.0, 2.0, -0.5},
                              .doc = "upper corner of the box of drawn targets (W axes)"}};
  RealParameter min_height_{this,
                            {.name = "min_height",
                             .unit = "m",
                             .value = 1.0,
                             .doc = "a drawn target lies no lower than this (W z)"}};
  RealParameter separation_min_{this,
                                {.name = "separation_min",
                                 .unit = "m",
                                 .value = 0.0,
                                 .min = 0.0,
                                 .doc = "an episode terminates when two robots are closer than "
                                        "this; 0: never"}};
  RealParameter tilt_max_{this,
                          {.name = "tilt_max",
                           .unit = "rad",
                           .value = kPi,
                           .min = 0.0,
                           .max = kPi,
                           .doc = "or a robot tilts more than this; pi: never"}};
  RealParameter distance_max_{this,
                              {.name = "distance_max",
                               .unit = "m",
                               .value = 0.0,
                               .min = 0.0,
                               .doc = "or is farther than this from the target; 0: never"}};

  std::vector<Robot> robots_;
  int drawn_target_ = -1;  ///< first EnvParam of a target that is drawn; -1: the scenario's
  double tilt_cosine_ = -2.0, farthest_ = kInfinity;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Formation, "formation", "1.0.0",
               "Several robots stand on a polygon about a target.");
