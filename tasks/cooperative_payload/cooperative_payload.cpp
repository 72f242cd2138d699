// Several robots carry one load, on rods or ropes, to a pose: its position and its heading.
#include <skybody/task_kit.h>

#include <vector>

#include "tasks/cooperative_payload/carried_limits.h"

namespace skybody {
namespace {

using namespace task_kit;

class CooperativePayload : public Task {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    target_.configure(setup);
    target_.require_within(limits_.bound());
    target_.require_above(limits_.height_min());
    find_load(setup);
    add_carriers(setup);
    is_shaped_ = shaping_.is_asked_for() || failure_reward_.value() != 0.0;
    for (Carrier& carrier : carriers_) declare_observation(setup, carrier);
    for (const Carrier& carrier : carriers_) setup.goal(carrier.index, carrier.body);
    setup.robot_rewards();
    error_info_ = infos_.add(setup, "payload_error", "m", "distance of the load from its target");
    yaw_info_ =
        infos_.add(setup, "payload_yaw_error", "rad", "magnitude of the yaw error, 0 .. pi");
    place_info_ =
        infos_.add(setup, "place_error", "m", "largest distance of a robot from its place");
    nearest_info_ =
        infos_.add(setup, "nearest_distance", "m", "smallest distance between two robots");
    limits_.configure(setup, infos_);
    success_ = declare_success(
        setup, infos_, "the load within `success_distance` and `success_yaw` of its target");
  }

  /// Draws a target pose of the load in the box, unless the scenario gives one.
  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>&, Start<Real>& start) const {
    target_.randomize(random(env), start);
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out) const {
    const LoadView<Real> load = view_load(env);
    const Real carried = load_reward(load);
    Real sum(0.0), farthest(0.0), nearest(kInfinity);
    PassedByTeam<Real> failed = limits_.by_load(load.body);
    const MaskOf<Real> load_failed = failed.any();
    for (const Carrier& carrier : carriers_) {
      const BodyMotion<Real> body = env.body(carrier.body);
      const Vec3<Real> place_error = place_of(carrier, env) - body.position;
      const Real own_nearest = observe(env, carrier, body, place_error, load, out.observation);
      const PassedByTeam<Real> own_failed = limits_.by_robot(body, own_nearest);
      const Real distance = norm(place_error);
      const Real own =
          carried + own_reward(body, distance, logical_or(load_failed, own_failed.any()));
      out.set_reward(carrier.index, own);
      sum += own;
      farthest = max(farthest, distance);
      nearest = min(nearest, own_nearest);
      failed.add(own_failed);
    }
    out.set_reward(sum / static_cast<double>(carriers_.size()));
    judge(out, load, failed);
    if (!out.wants_info()) return;
    error_info_.set(out.info, norm(load.error));
    yaw_info_.set(out.info, abs(load.yaw_error));
    place_info_.set(out.info, farthest);
    nearest_info_.set(out.info, nearest);
  }

  /// Goals: every robot's place about the load's target, heading along x of W.
  template <class Real>
  void goal(const EnvView<Real>& env, const State<Real>&, Values<Real> goal) const {
    for (int i = 0; i < static_cast<int>(carriers_.size()); ++i) {
      goal.set(4 * i, place_of(carriers_[static_cast<std::size_t>(i)], env));
      goal.set(4 * i + 3, Real(0.0));
    }
  }

 private:
  static constexpr double kPoseWeight = 2.56;  // (1.6)^2 [1/m^2], [1/rad^2]
  static constexpr double kPlaceReward = 0.5;  // of a robot at its place; the load's is 1
  static constexpr double kRateReward = 0.01;  // of a robot that does not rotate
  static constexpr double kNearWeight = 5.0;   // 1 / 0.2 m
  static constexpr int kRobotsNeeded = 2;

  /// Columns of a carrier about another one.
  struct Sight {
    int body;
    Part offset, velocity;
  };
  struct Carrier {
    int index, body;
    std::string name;
    Vec3<double> place;       ///< relative to the load, in the frame of its target [m]
    Vec3<double> attachment;  ///< on the load, in its frame [m]
    Part place_error = {};
    MotionParts motion = {};
    Part load_error = {}, load_yaw_error = {}, load_velocity = {}, load_attitude = {},
         load_angular_velocity = {}, attachment_offset = {};
    std::vector<Sight> others = {};  ///< in the order of carriers_, without the carrier itself
  };
  /// The load, as observed by all carriers.
  template <class Real>
  struct LoadView {
    BodyMotion<Real> body;
    Vec3<Real> error;  ///< target - position, W [m]
    Real yaw_error;    ///< wrapped [rad]
  };
  /// The robot named by `load`, or the only one without rotors and actions.
  void find_load(const Setup& setup) {
    if (!load_.value().empty()) {
      load_robot_ = setup.robot(load_.value());
    } else {
      for (int r = 0; r < setup.robots().size(); ++r) {
        const RobotInfo& info = setup.robots()[r];
        if (info.rotor_count > 0 || info.action_count > 0) continue;
        if (load_robot_ >= 0) {
          refuse("`", setup.robots()[load_robot_].name, "` and `", info.name,
                 "` could both be the load: say which one by `load`");
        }
        load_robot_ = r;
      }
    }
    if (load_robot_ < 0) {
      refuse(
          "there is no load: add a robot without rotors and controllers that couplings hang on the "
          "others, or take task `formation`");
    }
    if (setup.robots()[load_robot_].action_count > 0) {
      refuse("the load `", setup.robots()[load_robot_].name,
             "` takes actions: name a robot without controllers");
    }
    load_body_ = setup.robots()[load_robot_].first_body;
  }

  /// All robots that take actions.
  void add_carriers(const Setup& setup) {
    const RobotInfo& load = setup.robots()[load_robot_];
    const Vec3<double> origin = vec3_of(load.position);
    const Quat<double> heading = from_yaw(
        yaw(Quat<double>{load.rotation[0], load.rotation[1], load.rotation[2], load.rotation[3]}));
    for (int r = 0; r < setup.robots().size(); ++r) {
      const RobotInfo& info = setup.robots()[r];
      if (info.action_count == 0) continue;
      const Vec3<double> place = rotate_inverse(heading, vec3_of(info.position) - origin);
      carriers_.push_back({r, info.first_body, info.name, place, {0.0, 0.0, 0.0}});
    }
    const int count = static_cast<int>(carriers_.size());
    if (count < kRobotsNeeded) {
      refuse("a load is carried by two robots or more, and ", count,
             (count == 1 ? " takes" : " take"),
             " actions: add robots with controllers, or take task `payload`");
    }
    take_lists(count);
  }

  /// Places and attachments given in the scenario.
  void take_lists(int count) {
    for (const auto* list : {&places_, &attachments_}) {
      const std::string name = list == &places_ ? "places" : "attachments";
      if (list->count() == 0 || list->count() == 3 * count) continue;
      refuse("`", name, "` has ", list->count(), " values for ", count,
             " robots: write x, y, z for each, or leave it out");
    }
    for (int i = 0; i < count; ++i) {
      Carrier& carrier = carriers_[static_cast<std::size_t>(i)];
      if (places_.count() > 0) carrier.place = entry(places_, i);
      if (attachments_.count() > 0) carrier.attachment = entry(attachments_, i);
    }
  }
  static Vec3<double> entry(const RealsParameter& list, int i) {
    return {list.value(3 * i), list.value(3 * i + 1), list.value(3 * i + 2)};
  }
  static Vec3<double> vec3_of(const double (&v)[3]) { return {v[0], v[1], v[2]}; }
  /// The rotation about z by an angle [rad].
  template <class Real>
  static SKYBODY_INLINE Quat<Real> from_yaw(const Real& angle) {
    const SinCos<Real> half = sincos(0.5 * angle);
    return {half.cos, Real(0.0), Real(0.0), half.sin};
  }

  void declare_observation(const Setup& setup, Carrier& carrier) {
    const RobotParts part(setup, observation_, carrier.index, carrier.name + ".");
    carrier.place_error =
        part("place_error", "m", 3, "own place about the load's target - position, W");
    carrier.motion.declare(part);
    carrier.load_error = part("load_position_error", "m", 3, "target - position of the load, W");
    carrier.load_yaw_error =
        part("load_yaw_error", "rad", 1, "target yaw - yaw of the load, wrapped", kPi);
    carrier.load_velocity = part("load_velocity", "m/s", 3, "velocity of the load, W");
    carrier.load_attitude =
        part("load_attitude", "", 4, "quaternion w x y z of the load, W from its axes, with w >= 0",
             1.0);
    carrier.load_angular_velocity =
        part("load_angular_velocity", "rad/s", 3, "angular velocity of the load, in its axes");
    carrier.attachment_offset = part(
        "attachment", "m", 3, "own attachment point on the load (`attachments`) - position, W");
    for (const Carrier& other : carriers_) {
      if (other.index == carrier.index) continue;
      carrier.others.push_back(
          {other.body,
           part(other.name + ".offset", "m", 3, "position of the other - own position, W"),
           part(other.name + ".velocity", "m/s", 3, "velocity of the other, W")});
    }
  }

  template <class Real>
  SKYBODY_INLINE LoadView<Real> view_load(const EnvView<Real>& env) const {
    const BodyMotion<Real> body = env.body(load_body_);
    return {body, target_.position(env) - body.position,
            wrap_angle(target_.yaw(env) - yaw(body.rotation))};
  }

  template <class Real>
  SKYBODY_INLINE Vec3<Real> place_of(const Carrier& carrier, const EnvView<Real>& env) const {
    return target_.position(env) +
           rotate(from_yaw<Real>(target_.yaw(env)), constant<Real>(carrier.place));
  }
  template <class Real>
  static SKYBODY_INLINE Vec3<Real> constant(const Vec3<double>& v) {
    return {Real(v.x), Real(v.y), Real(v.z)};
  }

  /// Writes a carrier's part of the observation. @returns the distance of its nearest neighbour [m]
  template <class Real>
  SKYBODY_INLINE Real observe(const EnvView<Real>& env, const Carrier& carrier,
                              const BodyMotion<Real>& body, const Vec3<Real>& place_error,
                              const LoadView<Real>& load, const Values<Real>& row) const {
    carrier.place_error.set(row, place_error);
    carrier.motion.set(row, body);
    carrier.load_error.set(row, load.error);
    carrier.load_yaw_error.set(row, load.yaw_error);
    carrier.load_velocity.set(row, load.body.velocity);
    carrier.load_attitude.set(row, canonical(load.body.rotation));
    carrier.load_angular_velocity.set(row, load.body.angular_velocity);
    const Vec3<Real> attachment =
        load.body.position + rotate(load.body.rotation, constant<Real>(carrier.attachment));
    carrier.attachment_offset.set(row, attachment - body.position);
    Real nearest(kInfinity);
    for (const Sight& other : carrier.others) {
      const BodyMotion<Real> seen = env.body(other.body);
      const Vec3<Real> offset = seen.position - body.position;
      other.offset.set(row, offset);
      other.velocity.set(row, seen.velocity);
      nearest = min(nearest, norm(offset));
    }
    return nearest;
  }

  /// Common reward of the load: 1 in its pose, plus `load_precision_reward` close to it.
  template <class Real>
  SKYBODY_INLINE Real load_reward(const LoadView<Real>& load) const {
    const Real square = squared_norm(load.error);
    return closeness(square + load.yaw_error * load.yaw_error, kPoseWeight) +
           load_precision_reward_.value() * closeness(sqrt(square), kNearWeight);
  }

  /// A robot's own reward, in addition to the load's.
  template <class Real>
  SKYBODY_INLINE Real own_reward(const BodyMotion<Real>& body, const Real& distance,
                                 const MaskOf<Real>& failed) const {
    const Real own = kPlaceReward * closeness(distance * distance, kPoseWeight) +
                     kRateReward * closeness(squared_norm(body.angular_velocity), 1.0);
    if (!is_shaped_) return own;
    return own + shaping_.reward(distance, yaw(body.rotation)) - shaping_.cost(body.rotation) +
           choose(failed, Real(failure_reward_.value()), Real(0.0));
  }

  template <class Real>
  SKYBODY_INLINE void judge(Evaluation<Real>& out, const LoadView<Real>& load,
                            const PassedByTeam<Real>& failed) const {
    Verdict<Real> verdict(out);
    limits_.judge(verdict, failed);
    verdict.succeed(success_, logical_and(norm(load.error) < success_distance_.value(),
                                          abs(load.yaw_error) < success_yaw_.value()));
  }

  TextParameter load_{
      this, word("load", "", "name of the load; empty: the only robot without rotors and actions")};
  DrawnPose target_{
      this,
      {.target = {0.0, 0.0, 1.4, 0.0},
       .low = {-1.0, -1.0, 0.9},
       .high = {1.0, 1.0, 1.9},
       .doc = "x, y, z (W), yaw of the load; drawn for each episode if the scenario gives none"},
      0.4,
      "largest magnitude of a drawn heading of the load"};
  RealsParameter places_{this,
                         list("places", "m", {}, kAny,
                              "x, y, z of each robot relative to the load at its target, in axes "
                              "that turn with the target's yaw; none: as in the scenario")};
  RealsParameter attachments_{
      this,
      list("attachments", "m", {}, kAny,
           "x, y, z of each robot's point on the load, in the load's frame; none: its origin")};
  CarriedLimits limits_{this};
  RealParameter load_precision_reward_{this, real("load_precision_reward", "", 0.0, at_least(0.0),
                                                  "weight of 1 / (1 + |e| / 0.2 m) of the load in "
                                                  "every reward: a gradient close to the target")};
  GoalShaping shaping_{this};
  RealParameter failure_reward_{
      this, real("failure_reward", "", 0.0, at_most(0.0),
                 "added if an episode terminates, for a robot that has failed or whose load has")};
  RealParameter success_distance_{
      this, real("success_distance", "m", 0.15, at_least(0.0),
                 "the load has arrived if closer than this to its target (info `success`)")};
  RealParameter success_yaw_{
      this, real("success_yaw", "rad", 0.2, between(0.0, 4.0),
                 "the load has arrived if its heading error is less than this, too")};

  ObservationParts observation_;
  InfoParts infos_;
  Part error_info_, yaw_info_, place_info_, nearest_info_;
  Part success_;
  std::vector<Carrier> carriers_;
  int load_robot_ = -1, load_body_ = -1;
  bool is_shaped_ = false;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::CooperativePayload, "cooperative_payload", "1.0.0",
               "Several robots carry one load to a pose.");
