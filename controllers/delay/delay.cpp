// Delay: outputs the command of some physics steps ago, from a ring of the latest ones.
#include <skybody/plugin.h>

#include <vector>

namespace skybody {
namespace {

/// Largest size of the ring, which is memory of each environment.
constexpr int kMostSteps = 4096;

/// A signal's word and its number of values; 0: one per rotor; -1: given by the parameter `values`.
struct SignalSize {
  const char* word;
  Signal signal;
  int count;
};

/// @param least  number of values from the list of signals; 0: from the robot
constexpr int count_of(Signal signal, int least) {
  if (signal == Signal::kWrench) return 6;
  if (signal == Signal::kJoint) return -1;
  return least;
}

constexpr SignalSize kSignals[] = {
#define SKYBODY_ROW(symbol, type, word, least, most, doc) \
  {#word, Signal::k##type, count_of(Signal::k##type, least)},
    SKYBODY_SIGNALS(SKYBODY_ROW)
#undef SKYBODY_ROW
};

/// All signals that have values.
std::vector<const char*> signal_words() {
  std::vector<const char*> words;
  for (const SignalSize& size : kSignals) {
    if (size.signal != Signal::kNone) words.push_back(size.word);
  }
  return words;
}

class Delay : public Controller {
 public:
  static constexpr bool kSmooth = true;

  template <class Real>
  struct State {
    Word<Real> begun;   ///< 1 after the first command of the episode
    Word<Real> action;  ///< index of the action for which the latency was drawn
    Word<Real> steps;   ///< the random latency [physics steps]
    Word<Real> place;   ///< the ring's newest index
    Word<Real> age;     ///< age of the present output [physics steps]
  };

  void configure(const Setup& setup) override {
    if (jitter_.value() > latency_.value()) {
      refuse("`jitter` is ", jitter_.value(), " s, above `latency` ", latency_.value(),
             " s: the latency would be below 0; lower `jitter`");
    }
    seconds_per_step_ = setup.dt();
    per_second_ = 1.0 / setup.dt();
    const double most = round_half_even((latency_.value() + jitter_.value()) * per_second_);
    if (most >= kMostSteps) {
      refuse("`latency` and `jitter` are ", most, " physics steps together; allowed: up to ",
             kMostSteps - 1, ": lower them");
    }
    ring_ = static_cast<int>(most) + 1;
    draws_per_action_ = draw_.value() == "action";
    const SignalSize& size = signal_size();
    count_ = value_count(setup, setup.robot(), size);
    setup.input(size.signal, count_);
    setup.output(size.signal, count_);
    setup.buffer(ring_ * count_ + 1);
    setup.report("latency", "s", 1, ring_ * count_);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>& state, ConstValues<Real> input,
               Values<Real> output, Values<Real> buffer) const {
    const auto is_first = state.begun == Word<Real>(0);
    draw_latency(env, state, is_first);
    buffer.set(ring_ * count_, to_real(state.steps) * seconds_per_step_);
    state.begun = Word<Real>(1);
    state.place = next(state.place, is_first);
    // The output's age never grows by more than one step; overtaken commands are skipped. Until the
    // first command has arrived, it is the output all the same, because there is none before it.
    const Word<Real> aged = select(is_first, Word<Real>(0), state.age + Word<Real>(1));
    state.age = select(aged < state.steps, aged, state.steps);
    // A state loaded from outside may hold any words; keep the index within the ring.
    state.age = select(state.age < Word<Real>(ring_), state.age, Word<Real>(0));
    const auto wraps = state.age > state.place;
    const Word<Real> from =
        state.place + select(wraps, Word<Real>(ring_), Word<Real>(0)) - state.age;
    each_place(env, state.place, [&](int place, const MaskOf<Real>& lanes) {
      for (int k = 0; k < count_; ++k) {
        const int word = place * count_ + k;
        buffer.set(word, select(lanes, input[k], buffer[word]));
      }
    });
    each_place(env, from, [&](int place, const MaskOf<Real>& lanes) {
      for (int k = 0; k < count_; ++k) {
        output.set(k, select(lanes, buffer[place * count_ + k], output[k]));
      }
    });
  }

 private:
  /// Draws a latency per episode or per action.
  template <class Real>
  SKYBODY_INLINE void draw_latency(const EnvView<Real>& env, State<Real>& state,
                                   const MaskOf<Real>& is_first) const {
    auto is_due = is_first;
    if (draws_per_action_) is_due = logical_or(is_due, env.step() != state.action);
    if (!any(is_due)) return;
    Random<Real> draw = random(env);
    const Real offset = jitter_.value() * (2.0 * draw.uniform() - 1.0);
    const Real steps = round_half_even((latency_.value() + offset) * per_second_);
    state.steps = select(is_due, to_word(steps), state.steps);
    state.action = select(is_due, env.step(), state.action);
  }

  /// The next index of the ring.
  template <class Words, class Mask>
  SKYBODY_INLINE Words next(const Words& place, const Mask& is_first) const {
    const Words after = place + Words(1);
    const auto goes_on = logical_and(after < Words(ring_), place < Words(ring_));
    return select(logical_and(goes_on, logical_not(is_first)), after, Words(0));
  }

  /// Calls `use(place, lanes)` once for each distinct index among the lanes. Lanes whose episodes
  /// began together with the same latency share an index, so there are rarely more than a few.
  template <class Real, class Use>
  SKYBODY_INLINE void each_place(const EnvView<Real>& env, const Word<Real>& places,
                                 const Use& use) const {
    std::uint32_t left = bits_from_mask(env.served());
    for (int i = 0; i < kLanesOf<Real>; ++i) {
      if ((left >> i & 1u) == 0) continue;
      const std::uint64_t place = lane(places, i);
      const MaskOf<Real> lanes = places == Word<Real>(place);
      left &= ~bits_from_mask(lanes);
      use(static_cast<int>(place), lanes);
    }
  }

  const SignalSize& signal_size() const {
    for (const SignalSize& size : kSignals) {
      if (signal_.value() == size.word) return size;
    }
    throw std::logic_error("a signal that `choices` does not list");
  }

  int value_count(const Setup& setup, int robot, const SignalSize& size) const {
    if (values_.value() > 0) return static_cast<int>(values_.value());
    if (size.count > 0) return size.count;
    if (size.count < 0) {
      refuse("`values` is 0, but the signal `", signal_.value(),
             "` has as many as its controller takes: give their number");
    }
    const int rotors = setup.rotors_of(robot).size();
    if (rotors > 0) return rotors;
    refuse("robot `", setup.robots()[robot].name, "` has no rotors, which `", signal_.value(),
           "` speaks to: choose another `signal`");
  }

  TextParameter signal_{this,
                        required(choice("signal", "", signal_words(), "input and output signal"))};
  IntegerParameter values_{this,
                           integer("values", "", 0, between(0, 1000),
                                   "number of the signal's values; 0: the signal's own number")};
  RealParameter latency_{this, required(real("latency", "s", 0.0, between(0.0, 100.0),
                                             "mean time from a command to its effect"))};
  RealParameter jitter_{
      this, real("jitter", "s", 0.0, between(0.0, 100.0),
                 "half width of the random latency: latency - jitter to latency + jitter")};
  TextParameter draw_{
      this, choice("draw", "episode", {"episode", "action"}, "lifetime of a random latency")};

  double per_second_ = 0.0;        ///< physics steps per second
  double seconds_per_step_ = 0.0;  ///< the physics step [s]
  bool draws_per_action_ = false;
  int ring_ = 1;   ///< size: the longest latency plus the present step
  int count_ = 0;  ///< values of the signal
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Delay, "delay", "1.0.0",
               "Delays a command by a fixed or random latency [s].");
