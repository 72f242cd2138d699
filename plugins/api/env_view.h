// View of an environment in a plugin's step methods.
#pragma once

#include <type_traits>

#include "core/base/math/quat.h"
#include "core/base/math/vec3.h"
#include "core/plugin_abi/abi.h"
#include "core/plugin_abi/image.h"
#include "plugins/api/values.h"

namespace skybody {

/// Motion of one body frame. W: world, B: the body.
template <class Real>
struct BodyMotion {
  Vec3<Real> position;          ///< origin in W [m]
  Quat<Real> rotation;          ///< W from B, w x y z
  Vec3<Real> velocity;          ///< of the origin, W axes [m/s]
  Vec3<Real> angular_velocity;  ///< B axes [rad/s]
};

/// Sum of all contacts of one body.
template <class Real>
struct ContactSum {
  Vec3<Real> force;       ///< W axes [N]
  Vec3<Real> moment;      ///< about the body's origin, W axes [N m]
  MaskOf<Real> touching;  ///< whether the body is in contact
};

/// Force and moment that an inboard joint exerts on its body: constraint, spring, damper, limit and
/// drive together, at the latest physics state and with the commands of the last physics step. Zero
/// for a free base.
template <class Real>
struct JointReaction {
  Vec3<Real> force;   ///< W axes [N]
  Vec3<Real> moment;  ///< about the body's origin, W axes [N m]
};

/// Number of values in a ContactSum in the host's layout.
inline constexpr int kContactSumSize = SKYBODY_CONTACT_VALUES;

/// Number of values in a BodyMotion.
inline constexpr int kBodyMotionSize = 13;

/// One environment (Real = double) or several side by side (Real = Pack<W>), read-only. Indices of
/// bodies, rotors, sensors and parameters come from configure().
template <class Real>
class EnvView {
 public:
  /// @param lanes  lanes of the group: raw.lanes, or a constant for full groups, so that strides
  ///        become immediates
  /// @param first  the first lane that this view serves
  EnvView(const SkybodyLanes& raw, std::uint32_t lanes, std::uint32_t first, MaskOf<Real> mask)
      : raw_(raw), lanes_(lanes), first_(first), mask_(mask) {}

  /// Motion of a world body, at the latest physics state.
  BodyMotion<Real> body(int index) const {
    return motion(raw_.bodies, index, "body",
                  [](const SkybodyChecks& c) { return kBodyMotionSize * c.bodies; });
  }
  /// Motion of a world body at the start of the last physics step. Requires
  /// Setup::need_bodies_before() in configure().
  BodyMotion<Real> body_before(int index) const {
    return motion(raw_.bodies_before, index, "body_before",
                  [](const SkybodyChecks& c) { return kBodyMotionSize * c.bodies_before; });
  }
  /// Sum of all contacts of a world body. Requires Setup::need_contacts() in configure().
  ContactSum<Real> contact(int body) const {
    return contact_sum(raw_.contacts, body, "contact",
                       [](const SkybodyChecks& c) { return kContactSumSize * c.contacts; });
  }
  /// Contact between a body and one partner. @param pair  from Setup::contact_pair()
  ContactSum<Real> contact_pair(int pair) const {
    return contact_sum(raw_.contact_pairs, pair, "contact pair",
                       [](const SkybodyChecks& c) { return kContactSumSize * c.contact_pairs; });
  }
  /// Force and moment of a joint on the body that it moves. @param index  from
  /// Setup::joint_reaction()
  JointReaction<Real> joint_reaction(int index) const {
    const int first = SKYBODY_REACTION_VALUES * index;
    const auto v = values_of(raw_.joint_reactions, "joint reaction", [](const SkybodyChecks& c) {
      return SKYBODY_REACTION_VALUES * c.joint_reactions;
    });
    return {v.vec3(first), v.vec3(first + 3)};
  }
  /// Speed of a world rotor [rad/s], >= 0.
  Real rotor_speed(int index) const {
    return values_of(raw_.rotor_speed, "rotor",
                     [](const SkybodyChecks& c) { return c.rotors; })[index];
  }
  /// Last command of a world rotor from its controllers [rad/s], before any limit. In apply() it is
  /// the command for the physics step that begins. Without a chain that drives rotors it is the
  /// scenario's value.
  Real rotor_command(int index) const {
    return values_of(raw_.rotor_command, "rotor",
                     [](const SkybodyChecks& c) { return c.rotors; })[index];
  }
  /// A joint coordinate [rad] or [m]; its index is BodyInfo::first_q.
  Real q(int index) const {
    return values_of(raw_.q, "q", [](const SkybodyChecks& c) { return c.q; })[index];
  }
  /// A joint rate [rad/s] or [m/s]; its index is BodyInfo::first_u.
  Real u(int index) const {
    return values_of(raw_.u, "u", [](const SkybodyChecks& c) { return c.u; })[index];
  }
  /// A randomizable value of this environment; see Setup::find_params().
  Real param(int index) const {
    return values_of(raw_.params, "param", [](const SkybodyChecks& c) { return c.params; })[index];
  }
  /// Three parameters from `first` on: a vector such as a rotor's position.
  Vec3<Real> param_vec3(int first) const {
    return {param(first), param(first + 1), param(first + 2)};
  }
  /// A sensor's output value; see Setup::sensor().
  Real sensor(int index) const {
    return values_of(raw_.sensors, "sensor",
                     [](const SkybodyChecks& c) { return c.sensors; })[index];
  }
  /// Value `index` of this step's action, clipped to [-1, 1]. A robot's values start at
  /// RobotInfo::first_action.
  Real action(int index) const {
    return values_of(raw_.action, "action", [](const SkybodyChecks& c) { return c.action; })[index];
  }
  /// Value `index` of the chains' commands computed from the action, in physical units; see
  /// ChainInfo::first_command.
  Real command(int index) const {
    return values_of(raw_.command, "command",
                     [](const SkybodyChecks& c) { return c.command; })[index];
  }
  /// Sensors: a value of an effect, after the physics step that its last call was for. @param place
  /// from Setup::offered()
  Real offered(int place) const {
    const auto number = [](const SkybodyChecks& c) { return c.offered; };
    const bool is_there = raw_.checks == nullptr || place < raw_.checks->offered;
    if (!is_there) return values_of(nullptr, "offered", number)[place];
    return ConstValues<Real>(raw_.plugin_words + first_, lanes_)[raw_.offered[place]];
  }
  /// Scratch memory of this call: Setup::scratch() values with undefined content.
  Values<Real> scratch() const {
    return values(raw_.scratch, first_, mask_, "scratch",
                  [](const SkybodyChecks& c) { return c.scratch; });
  }
  /// Scratch memory of this call: Setup::scratch_block() doubles in a row, with undefined content.
  /// Methods written for plain double only: lanes are served one after another.
  double* scratch_block() const {
    static_assert(std::is_same_v<Real, double>, "one block for each lane: write for plain double");
    return raw_.scratch;
  }
  /// Setup::memo() values that keep the last written content, also in lanes that are not served: a
  /// cache for results, stored together with the inputs they were computed from. Other calls,
  /// threads and environments may have written the content, so compare the inputs before you use
  /// it. Not available for dual numbers, because the memory has no room for tangents.
  Values<Real> memo() const {
    static_assert(!kIsDual<Real>);
    return values(raw_.memo, first_, MaskOf<Real>(true), "memo",
                  [](const SkybodyChecks& c) { return c.memo; });
  }

  /// Sensors in sense(), written for plain double: the values of an image of this environment, in C
  /// order. They keep their content from the previous sense(); at a reset and after a restore
  /// (draws_again()) they start at 0.
  template <class T>
  T* pixels(const Image<T>& image) const {
    static_assert(std::is_same_v<Real, double>,
                  "images are written environment by environment: write sense() for plain double");
    return reinterpret_cast<T*>(raw_.images + first_ * raw_.image_stride + image.offset);
  }

  /// Sensors in sense(): physics steps after this one before the images of this sensor are read; 0:
  /// they are read next; SKYBODY_NEVER_READ: nothing reads them. An image that a later call writes
  /// again before it is read can be left as it is.
  std::uint64_t steps_to_read() const { return raw_.steps_to_read; }
  /// Sensors with images in sense(): the state was saved and restored, and images are not part of
  /// it. This call draws them again, as the last call that drew left them, from State and buffer
  /// alone: bodies, parameters and keys may have changed since. It writes nothing else.
  bool draws_again() const { return raw_.steps_to_read == SKYBODY_DRAW_AGAIN; }

  /// Seed of the environment's random numbers.
  Word<Real> seed() const { return word(raw_.key, 0); }
  /// Id of the environment's random stream: its id in the batch, or another id after a fork with
  /// `rekey`.
  Word<Real> stream_env() const { return word(raw_.key, 1); }
  /// Resets of this environment so far; 1 in its first episode.
  Word<Real> episode() const { return word(raw_.episode, 0); }
  /// Actions taken in this episode. 0 at a reset. The current action is counted in evaluate() and
  /// goal() (1 after the first action), but not in process(), control() and sense().
  Word<Real> step() const { return word(raw_.step, 0); }
  /// Physics steps completed in this episode.
  Word<Real> physics_step() const { return word(raw_.physics_step, 0); }
  /// Lanes that are being served. The others hold undefined values.
  MaskOf<Real> served() const { return mask_; }

  /// For the library: stride between the values of a lane.
  std::uint32_t lanes() const { return lanes_; }
  /// For the library: a view of these lanes in an array; `base` may be null if nothing is read.
  /// @param name  name of the values in messages; @param size  size(checks): their number
  template <class Size>
  ConstValues<Real> const_values(const double* base, std::uint32_t first, const char* name,
                                 const Size& size) const {
    return {base == nullptr ? nullptr : base + first, lanes_, bounds(name, size)};
  }
  /// For the library: the writable counterpart of const_values().
  template <class Size>
  Values<Real> values(double* base, std::uint32_t first, const MaskOf<Real>& mask, const char* name,
                      const Size& size) const {
    return {base == nullptr ? nullptr : base + first, lanes_, mask, bounds(name, size)};
  }

 private:
  template <class Size>
  Bounds<Real> bounds(const char* name, const Size& size) const {
    SkybodyChecks* const checks = raw_.checks;
    if (checks == nullptr) return {};
    return {checks, name, size(*checks)};
  }
  template <class Size>
  ConstValues<Real> values_of(const double* base, const char* name, const Size& size) const {
    return const_values(base, first_, name, size);
  }
  Word<Real> word(const std::uint64_t* base, int k) const {
    return load_words<Real>(base + static_cast<std::size_t>(k) * lanes_ + first_);
  }
  template <class Size>
  BodyMotion<Real> motion(const double* base, int index, const char* name, const Size& size) const {
    const int first = kBodyMotionSize * index;
    const auto v = values_of(base, name, size);
    return {v.vec3(first), v.quat(first + 3), v.vec3(first + 7), v.vec3(first + 10)};
  }

  template <class Size>
  ContactSum<Real> contact_sum(const double* base, int index, const char* name,
                               const Size& size) const {
    const int first = kContactSumSize * index;
    const auto v = values_of(base, name, size);
    return {v.vec3(first), v.vec3(first + 3), v[first + 6] > 0.5};
  }

  SkybodyLanes raw_;  // a copy: no write can alias its pointers
  std::uint32_t lanes_, first_;
  MaskOf<Real> mask_;
};

}  // namespace skybody
