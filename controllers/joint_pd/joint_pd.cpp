// Joint positions to joint efforts: a PD with gravity compensation. Its gains are a bandwidth and a
// damping ratio times the inertia that each joint moves in the present pose.
#include <cmath>
#include <limits>
#include <vector>

#include "controllers/common/driven_joint.h"

namespace skybody {
namespace {

class JointPd : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    control::require_joints(setup, setup.robot(), joints_.values());
    check_bandwidths();
    const int robot = setup.robot();
    own_ = constants_.value() == "own";
    gravity_ = control::gravity_of(setup);
    first_gravity_ = setup.find_params("gravity")[0];
    std::vector<double> low, high;
    for (const std::string& name : joints_.values()) {
      Driven driven{control::driven_joint(setup, robot, name), bandwidth_of(driven_.size()), {}};
      set_range(name, driven.joint);
      for (int b = driven.joint.body; b < setup.bodies().size(); ++b) {
        if (setup.bodies()[b].robot == robot && control::hangs_on(setup, b, driven.joint.body)) {
          driven.carried.push_back(carried(setup, b));
        }
      }
      declare_drive(setup, driven.joint);
      low.push_back(driven.joint.low);
      high.push_back(driven.joint.high);
      driven_.push_back(driven);
    }
    setup.input(Signal::kJoint, low, high);
    setup.output(Signal::kJoint, static_cast<int>(driven_.size()));
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input,
               Values<Real> output) const {
    for (std::size_t k = 0; k < driven_.size(); ++k) {
      const int i = static_cast<int>(k);
      output.set(i, effort(env, driven_[k], input[i]));
    }
  }

 private:
  /// A body beyond a joint.
  struct Carried {
    int body, first_param;
    double mass;
    Vec3<double> com;
    SymMat3<double> inertia;
  };
  struct Driven {
    control::DrivenJoint joint;
    double bandwidth;  ///< [rad/s]
    std::vector<Carried> carried;
  };
  template <class Real>
  struct Mass {
    Real mass;
    Vec3<Real> com;
    SymMat3<Real> inertia;
  };

  void check_bandwidths() const {
    const int given = bandwidth_.count(), joints = static_cast<int>(joints_.values().size());
    if (given == 1 || given == joints) return;
    refuse("`bandwidth` has ", given, " values, `joints` ", joints,
           ": give one for all, or one for each");
  }
  double bandwidth_of(std::size_t k) const {
    return bandwidth_.value(bandwidth_.count() == 1 ? 0 : static_cast<int>(k));
  }

  /// `low` and `high`, or the joint's own limits.
  void set_range(const std::string& name, control::DrivenJoint& joint) const {
    if (low_.value() != high_.value()) {
      control::require_order("low", low_.value(), "high", high_.value());
      joint.low = low_.value();
      joint.high = high_.value();
    }
    if (!(joint.low < joint.high)) {
      refuse("joint `", name, "` has no range: give `low` and `high`");
    }
  }

  static Carried carried(const Setup& setup, int body) {
    const BodyInfo& info = setup.bodies()[body];
    return {body, info.first_param, info.mass, control::vec3(info.com), control::inertia_of(info)};
  }

  void declare_drive(const Setup& setup, const control::DrivenJoint& joint) const {
    const double infinity = std::numeric_limits<double>::infinity();
    const double limit = effort_limit_.value() > 0.0 ? effort_limit_.value() : infinity;
    setup.joint({joint.body, 0, SKYBODY_JOINT_EFFORT, 0.0, 0.0, limit, 0.0, -limit, limit});
  }

  template <class Real>
  SKYBODY_INLINE Mass<Real> mass_of(const EnvView<Real>& env, const Carried& body) const {
    if (!own_) {
      return {Real(body.mass), control::lift<Real>(body.com), control::lift<Real>(body.inertia)};
    }
    const int i = body.first_param + SKYBODY_BODY_INERTIA;
    return {env.param(body.first_param + SKYBODY_BODY_MASS),
            env.param_vec3(body.first_param + SKYBODY_BODY_COM),
            {env.param(i), env.param(i + 1), env.param(i + 2), env.param(i + 3), env.param(i + 4),
             env.param(i + 5)}};
  }

  /// [N m] or [N].
  template <class Real>
  SKYBODY_INLINE Real effort(const EnvView<Real>& env, const Driven& driven,
                             const Real& command) const {
    const control::DrivenJoint& joint = driven.joint;
    const BodyMotion<Real> moved = env.body(joint.body);
    const Vec3<Real> axis = rotate(moved.rotation, control::lift<Real>(joint.axis));
    const Vec3<Real> at = moved.position + rotate(moved.rotation, control::lift<Real>(joint.point));
    Vec3<Real> gravity{Real(0.0), Real(0.0), Real(-gravity_)};
    if (own_) gravity = env.param_vec3(first_gravity_);
    Real inertia(0.0), weight(0.0);
    for (const Carried& carried : driven.carried) {
      const BodyMotion<Real> motion = env.body(carried.body);
      const Mass<Real> body = mass_of(env, carried);
      if (joint.slides) {
        inertia += body.mass;
        weight += body.mass * dot(axis, gravity);
        continue;
      }
      const Vec3<Real> arm = (motion.position + rotate(motion.rotation, body.com)) - at;
      const Vec3<Real> own_axis = rotate_inverse(motion.rotation, axis);
      inertia +=
          body.mass * squared_norm(cross(axis, arm)) + dot(own_axis, body.inertia * own_axis);
      weight += body.mass * dot(axis, cross(arm, gravity));
    }
    const Real error = clamp(command, Real(joint.low), Real(joint.high)) - env.q(joint.q);
    const double w = driven.bandwidth;
    const Real setpoint = (w * w) * error - (2.0 * damping_.value() * w) * env.u(joint.u);
    return inertia * setpoint - (bears_weight_.value() ? weight : Real(0.0));
  }

  TextsParameter joints_{this, words("joints", "names of the joints, in order")};
  RealsParameter bandwidth_{this,
                            list("bandwidth", "rad/s", {20.0}, between(1e-3, 1e5),
                                 "bandwidth of the loop: one for all joints, or one per joint")};
  RealParameter damping_{this, real("damping_ratio", "", 1.0, between(0.0, 100.0),
                                    "damping ratio of the loop; 1: no overshoot")};
  BooleanParameter bears_weight_{
      this, boolean("gravity", true, "compensate the weight beyond the joint")};
  TextParameter constants_{this, choice("constants", "nominal", {"nominal", "own"},
                                        "masses and gravity used for gains: the scenario's, or "
                                        "each environment's randomized ones")};
  RealParameter effort_limit_{this, real("effort_limit", "N m or N", 0.0, between(0.0, 1e6),
                                         "largest effort of a drive; 0: no limit")};
  RealParameter low_{this, real("low", "rad or m", 0.0, between(-1e6, 1e6),
                                "position for action -1; low = high: the joint's limits")};
  RealParameter high_{this,
                      real("high", "rad or m", 0.0, between(-1e6, 1e6), "position for action +1")};

  std::vector<Driven> driven_;
  bool own_ = false;
  double gravity_ = 0.0;
  int first_gravity_ = 0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::JointPd, "joint_pd", "1.0.0",
               "Converts joint positions to efforts by a PD scaled with the moved inertia.");
