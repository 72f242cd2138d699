// Inverse kinematics of an arm: pose of its end to joint positions, by damped least squares. Chain
// `joint` with position drives, or `joint_pd`.
#include <cmath>
#include <string>
#include <vector>

#include "controllers/common/driven_joint.h"
#include "controllers/common/position_box.h"

namespace skybody {
namespace {

class Arm : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    base_ = control::base_of(setup, robot);
    in_world_ = frame_.value() == "world";
    step_ = max_rate_.value() * setup.dt();
    const LinkInfo& link = setup.link(robot, link_.value());
    const Quat<double> turn{link.rotation[0], link.rotation[1], link.rotation[2], link.rotation[3]};
    end_ = {control::vec3(link.position) + rotate(turn, point_.vec3()), turn};
    set_joints(setup, robot, link.body);
    const Vec3<double> low = place_min_.vec3(), high = place_max_.vec3();
    control::require_order("place_min", low, "place_max", high);
    control::PositionBox::declare_pose(setup, low, high);
    setup.output(Signal::kJoint, count());
    setup.buffer(count());
  }

  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>&, Values<Real> buffer) const {
    for (int k = 0; k < count(); ++k) buffer.set(k, env.q(segment(k).joint.q));
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input, Values<Real> output,
               Values<Real> buffer) const {
    Real q[kMost], change[kMost];
    for (int k = 0; k < count(); ++k) q[k] = buffer[k];
    const Posture<Real> now = posture(q);
    towards(now, target(env, input), change);
    for (int k = 0; k < count(); ++k) {
      const control::DrivenJoint& joint = segment(k).joint;
      Real next = q[k] + clamp(change[k], Real(-step_), Real(step_));
      if (joint.low < joint.high) next = clamp(next, Real(joint.low), Real(joint.high));
      output.set(k, next);
      buffer.set(k, select(is_nan(next), q[k], next));  // a NaN command does not enter the state
    }
  }

 private:
  static constexpr int kMost = 8;  ///< joints

  template <class Real>
  struct Frame {
    Vec3<Real> position;
    Quat<Real> rotation;
  };
  /// A joint and the body that it moves.
  struct Segment {
    control::DrivenJoint joint;
    Frame<double> in_parent, back;  ///< joint's frame in the preceding body; body's in the joint's
  };
  /// Axes and positions in the frame of the base.
  template <class Real>
  struct Posture {
    Vec3<Real> axis[kMost], at[kMost];
    Frame<Real> end;
  };

  int count() const { return static_cast<int>(segments_.size()); }
  const Segment& segment(int k) const { return segments_[static_cast<std::size_t>(k)]; }

  /// The joints from the base to the end, which must equal those of the scenario.
  void set_joints(const Setup& setup, int robot, int body) {
    std::vector<std::string> way;
    for (int b = body; b != base_; b = setup.bodies()[b].parent) {
      way.insert(way.begin(), setup.bodies()[b].joint_name);
    }
    if (way.empty()) {
      refuse("link `", link_.value(),
             "` is part of the base: no joint moves it; name a link of an arm");
    }
    if (way.size() > kMost) {
      refuse("link `", link_.value(), "` is behind ", way.size(), " joints: at most ", kMost);
    }
    if (joints_.values() != way) {
      std::string names;
      for (const std::string& name : way) names += (names.empty() ? "" : ", ") + name;
      refuse("`joints` must be those from the base to link `", link_.value(), "`, in order: [",
             names, "]");
    }
    for (const std::string& name : way) {
      const BodyInfo& info = setup.joint(robot, name);
      const Quat<double> turn = control::rotation_of(info.joint_in_body);
      segments_.push_back(
          {control::driven_joint(setup, robot, name),
           {control::position_of(info.joint_in_parent), control::rotation_of(info.joint_in_parent)},
           {-rotate_inverse(turn, control::position_of(info.joint_in_body)), conjugate(turn)}});
    }
  }

  /// Frame b in the parent of a, from b in a.
  template <class Real>
  static SKYBODY_INLINE Frame<Real> compose(const Frame<Real>& a, const Frame<double>& b) {
    const Quat<Real> turn{Real(b.rotation.w), Real(b.rotation.x), Real(b.rotation.y),
                          Real(b.rotation.z)};
    return {a.position + rotate(a.rotation, control::lift<Real>(b.position)), a.rotation * turn};
  }

  /// Forward kinematics. @param q  positions of the joints
  template <class Real>
  SKYBODY_INLINE Posture<Real> posture(const Real (&q)[kMost]) const {
    Posture<Real> now;
    const Real zero(0.0);
    Frame<Real> frame{{zero, zero, zero}, Quat<Real>::identity()};
    for (int k = 0; k < count(); ++k) {
      const Segment& s = segment(k);
      frame = compose(frame, s.in_parent);
      now.at[k] = frame.position;
      if (s.joint.slides) {
        now.axis[k] = rotate(frame.rotation, Vec3<Real>{Real(1.0), zero, zero});
        frame.position += now.axis[k] * q[k];
      } else {
        now.axis[k] = rotate(frame.rotation, Vec3<Real>{zero, zero, Real(1.0)});
        const SinCos<Real> half = sincos(0.5 * q[k]);
        frame.rotation = frame.rotation * Quat<Real>{half.cos, zero, zero, half.sin};
      }
      frame = compose(frame, s.back);
    }
    now.end = compose(frame, end_);
    return now;
  }

  /// Target pose of the end, in the frame of the base.
  template <class Real>
  SKYBODY_INLINE Frame<Real> target(const EnvView<Real>& env, ConstValues<Real> input) const {
    const Frame<Real> target{input.vec3(0), control::unit_or_identity(input.quat(3))};
    if (!in_world_) return target;
    const BodyMotion<Real> base = env.body(base_);
    return {rotate_inverse(base.rotation, target.position - base.position),
            conjugate(base.rotation) * target.rotation};
  }

  /// One step of damped least squares: (J^T J + damping^2 + |e|^2 / 2) change = J^T e. The last
  /// term prevents a stretched arm from oscillating at a target out of reach.
  template <class Real>
  SKYBODY_INLINE void towards(const Posture<Real>& now, const Frame<Real>& target,
                              Real (&change)[kMost]) const {
    const Vec3<Real> away = target.position - now.end.position;
    const Quat<Real> left = target.rotation * conjugate(now.end.rotation);
    const Real weight(orientation_weight_.value());
    const Vec3<Real> turn = Vec3<Real>{left.x, left.y, left.z} * (copysign(2.0, left.w) * weight);
    const Real damping =
        damping_.value() * damping_.value() + 0.5 * (squared_norm(away) + squared_norm(turn));
    Vec3<Real> move[kMost], spin[kMost];  // columns of J
    for (int k = 0; k < count(); ++k) {
      const bool slides = segment(k).joint.slides;
      move[k] = slides ? now.axis[k] : cross(now.axis[k], now.end.position - now.at[k]);
      spin[k] = slides ? now.axis[k] * Real(0.0) : now.axis[k] * weight;
    }
    Real factor[kMost][kMost];
    for (int r = 0; r < count(); ++r) {  // Cholesky, with the forward substitution
      change[r] = dot(move[r], away) + dot(spin[r], turn);
      for (int c = 0; c <= r; ++c) {
        Real sum = dot(move[r], move[c]) + dot(spin[r], spin[c]);
        if (c == r) sum += damping;
        for (int k = 0; k < c; ++k) sum -= factor[r][k] * factor[c][k];
        factor[r][c] = c == r ? sqrt(sum) : sum / factor[c][c];
        if (c < r) change[r] -= factor[r][c] * change[c];
      }
      change[r] = change[r] / factor[r][r];
    }
    for (int r = count() - 1; r >= 0; --r) {
      for (int k = r + 1; k < count(); ++k) change[r] -= factor[k][r] * change[k];
      change[r] = change[r] / factor[r][r];
    }
  }

  TextsParameter joints_{this, words("joints", "joints from the base to the link, in order")};
  TextParameter link_{this, required(word("link", "", "link that carries the end"))};
  RealsParameter point_{
      this, reals("point", "m", {0.0, 0.0, 0.0}, kAny, "position of the end in the link's frame")};
  TextParameter frame_{this, choice("frame", "world", {"world", "base"}, "frame of the commands")};
  RealParameter orientation_weight_{this,
                                    real("orientation_weight", "m/rad", 0.0, between(0.0, 1e3),
                                         "weight of the orientation error; 0: position only")};
  RealParameter damping_{
      this, real("damping", "m", 0.02, between(1e-4, 10.0),
                 "damping of the least squares: lever arms shorter than this move little")};
  RealParameter max_rate_{this, real("max_rate", "rad/s or m/s", 3.0, between(1e-6, 1e6),
                                     "largest rate of the output positions")};
  RealsParameter place_min_{
      this, reals("place_min", "m", {-1.0, -1.0, -1.0}, kAny, "position for action -1")};
  RealsParameter place_max_{
      this, reals("place_max", "m", {1.0, 1.0, 1.0}, kAny, "position for action +1")};

  std::vector<Segment> segments_;
  Frame<double> end_{};  ///< in the last body's frame
  int base_ = 0;
  bool in_world_ = true;
  double step_ = 0.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Arm, "arm", "1.0.0",
               "Converts the pose of an arm's end to joint positions.");
