// Rotor failure: from a random time on, rotors are stuck at a speed, weaker, or off.
#include <algorithm>
#include <vector>

#include "effects/common/rotors.h"

namespace skybody {
namespace {

class RotorFailure : public Effect {
 public:
  static constexpr bool kSmooth = true;

  template <class Real>
  struct State {
    Real time;   ///< of the failure [s]; -1: none in this episode
    Real rotor;  ///< index in rotors_ of the failed one; -1: all of them fail
  };

  void configure(const Setup& setup) override {
    dt_ = setup.dt();
    if (latest_.value() < earliest_.value()) {
      refuse("`latest` is ", latest_.value(), " s, before `earliest` ", earliest_.value(),
             " s: raise it; both the same is a fixed time");
    }
    const double end = setup.horizon() * setup.action_repeat() * dt_;
    if (setup.horizon() > 0 && latest_.value() >= end) {
      refuse("`latest` is ", latest_.value(), " s, but an episode ends after ", end,
             " s: let rotors fail before");
    }
    const int robot = setup.robot(robot_.value());
    if (setup.rotors_of(robot).size() == 0) {
      refuse("robot `", setup.robots()[robot].name,
             "` has no rotors that could fail: name another one in `robot`");
    }
    choose_rotors(setup, robot);
    is_partial_ = kind_.value() == "partial";
    is_stuck_ = kind_.value() == "stuck";
    setup.holds(is_partial_ ? HeldInput::kRotorGain : HeldInput::kRotorLimit);
    const int count = setup.rotors_of(robot).size();
    setup.buffer(1 + 2 * count);
    setup.report("time", "s", 1, 0);
    setup.report("failed", "", count, 1);
    first_speed_ = 1 + count;
  }

  /// Draws whether, when and which rotor fails.
  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state, Values<Real> buffer) const {
    Random<Real> draw = random(env);
    const auto fails = draw.uniform() < probability_(env);
    const Real time = draw.uniform(Real(earliest_.value()), Real(latest_.value()));
    const Real drawn = to_real(draw.integer(rotors_.size()));
    state.time = select(fails, time, Real(-1.0));
    state.rotor = rotor_names_.values().empty() ? drawn : Real(-1.0);
    buffer.set(0, state.time);
  }

  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>& state, Held<Real>& held,
             Values<Real> buffer) const {
    // The step whose start is nearest to the time, so that a time on the grid is met exactly.
    const Real now = (to_real(env.physics_step()) + 0.5) * dt_;
    const auto is_over = logical_and(state.time >= 0.0, now >= state.time);
    for (std::size_t i = 0; i < rotors_.size(); ++i) {
      const Rotor& rotor = rotors_[i];
      const auto is_meant =
          logical_or(state.rotor < -0.5, abs(state.rotor - static_cast<double>(i)) < 0.5);
      const auto has_failed = logical_and(is_over, is_meant);
      const auto is_new = logical_and(has_failed, buffer[1 + rotor.place] < 0.5);
      const int frozen = first_speed_ + rotor.place;
      buffer.set(frozen, select(is_new, env.rotor_speed(rotor.index), buffer[frozen]));
      buffer.set(1 + rotor.place, select(has_failed, Real(1.0), Real(0.0)));
      fail(env, rotor.index, has_failed, buffer[frozen], held);
    }
  }

 private:
  struct Rotor {
    int index;  ///< world index
    int place;  ///< index within its robot
  };

  /// @param speed  of the rotor when it failed [rad/s]
  template <class Real>
  SKYBODY_INLINE void fail(const EnvView<Real>& env, int rotor, const MaskOf<Real>& has_failed,
                           const Real& speed, Held<Real>& held) const {
    if (is_partial_) {
      held.scale_thrust(rotor, select(has_failed, thrust_gain_(env), Real(1.0)));
      held.scale_moment(rotor, select(has_failed, moment_gain_(env), Real(1.0)));
      return;
    }
    const Real kept = is_stuck_ ? speed : Real(0.0);
    held.limit_speed(rotor, select(has_failed, kept, Real(0.0)),
                     select(has_failed, kept, Real(kInfinity)));
  }

  /// The rotors selected by name or index; without names all, one of which is drawn.
  void choose_rotors(const Setup& setup, int robot) {
    const View<RotorInfo> all = setup.rotors_of(robot);
    const auto first = static_cast<int>(all.begin() - setup.rotors().begin());
    for (const std::string& name : rotor_names_.values()) {
      const int place = place_of(name, all);
      for (const Rotor& rotor : rotors_) {
        if (rotor.place != place) continue;
        refuse("`rotors` names `", name, "` twice: name each rotor once");
      }
      rotors_.push_back({first + place, place});
    }
    for (int i = 0; rotor_names_.values().empty() && i < all.size(); ++i) {
      rotors_.push_back({first + i, i});
    }
  }

  static int place_of(const std::string& name, const View<RotorInfo>& all) {
    std::string known;
    for (int i = 0; i < all.size(); ++i) {
      if (name == all[i].name || name == std::to_string(i)) return i;
      known += (i > 0 ? ", " : "") + std::string(all[i].name);
    }
    refuse("`rotors`: no rotor `", name, "`: there are ", known, ", or 0 to ", all.size() - 1,
           " by their places");
  }

  TextParameter robot_{this, word("robot", "", "robot with the rotors; empty: the only one")};
  TextsParameter rotor_names_{
      this, words("rotors", "rotors that fail together, by name or index; empty: a random one")};
  TextParameter kind_{this,
                      choice("kind", "off", {"off", "stuck", "partial"},
                             "slows down to rest, keeps its speed, or loses thrust and moment")};
  RealParameter earliest_{this, real("earliest", "s", 1.0, between(0.0, 1e6),
                                     "earliest time of the failure in the episode")};
  RealParameter latest_{this, real("latest", "s", 1.0, between(0.0, 1e6),
                                   "latest time of the failure; uniform between both")};
  RealParameter probability_{this, randomizable(real("probability", "", 1.0, between(0.0, 1.0),
                                                     "probability of a failure in an episode"))};
  RealParameter thrust_gain_{this, randomizable(real("thrust_gain", "", 0.5, between(0.0, 10.0),
                                                     "kind partial: factor on the thrust"))};
  RealParameter moment_gain_{this,
                             randomizable(real("moment_gain", "", 0.5, between(0.0, 10.0),
                                               "kind partial: factor on the reaction moment"))};

  bool is_partial_ = false, is_stuck_ = false;
  double dt_ = 0.0;
  int first_speed_ = 0;  ///< buffer word: speeds at the failure
  std::vector<Rotor> rotors_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::RotorFailure, "rotor_failure", "1.0.0",
               "Rotors that fail at a random time: off, stuck, or weaker.");
