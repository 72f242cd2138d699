// Detects the methods of a plugin class, their Real types and signatures. Every method may take the
// instance's buffer as one more argument.
#pragma once

#include <type_traits>

#include "core/base/simd/kernels.h"
#include "plugins/api/plugin.h"
#include "plugins/api/state.h"

namespace skybody::plugin_export {

template <class Env>
struct RealOfImpl;
template <class Real>
struct RealOfImpl<EnvView<Real>> {
  using type = Real;
};
/// The Real of a `const EnvView<Real>&`.
template <class Env>
using RealOf = typename RealOfImpl<std::remove_cvref_t<Env>>::type;

template <class... Types>
struct TypeList {};

/// Declares a method that plugin classes may have: its name, the type of its State argument, and
/// the arguments after `const EnvView<Real>&` and State.
// No call below is always_inline, see kernels.h.
#define SKYBODY_PLUGIN_METHOD(TYPE, NAME, STATE, ...)                      \
  struct TYPE {                                                            \
    template <class T, class... Arguments>                                 \
    static auto call(const T& plugin, Arguments&&... arguments)            \
        -> decltype(plugin.NAME(static_cast<Arguments&&>(arguments)...)) { \
      return plugin.NAME(static_cast<Arguments&&>(arguments)...);          \
    }                                                                      \
    struct Namesake {                                                      \
      void NAME();                                                         \
    };                                                                     \
    template <class Both>                                                  \
    static constexpr bool kNamesOneThing = requires {                      \
      &Both::NAME;                                                         \
    };                                                                     \
    template <class T, class Real>                                         \
    using State = STATE&;                                                  \
    template <class Real>                                                  \
    using Arguments = TypeList<__VA_ARGS__>;                               \
  }

#define SKYBODY_STATE StateOf<T, Real>
#define SKYBODY_CONST_STATE const StateOf<T, Real>
SKYBODY_PLUGIN_METHOD(ResetMethod, reset, SKYBODY_STATE);
SKYBODY_PLUGIN_METHOD(ControlMethod, control, SKYBODY_STATE, ConstValues<Real>, Values<Real>);
SKYBODY_PLUGIN_METHOD(SenseMethod, sense, SKYBODY_STATE, Values<Real>);
SKYBODY_PLUGIN_METHOD(RandomizeMethod, randomize, SKYBODY_STATE, Start<Real>&);
SKYBODY_PLUGIN_METHOD(ApplyMethod, apply, SKYBODY_STATE, Held<Real>&);
SKYBODY_PLUGIN_METHOD(ProcessMethod, process, SKYBODY_STATE, ConstValues<Real>, Values<Real>);
SKYBODY_PLUGIN_METHOD(EvaluateMethod, evaluate, SKYBODY_STATE, Evaluation<Real>&);
SKYBODY_PLUGIN_METHOD(GoalMethod, goal, SKYBODY_CONST_STATE, Values<Real>);
SKYBODY_PLUGIN_METHOD(GoalMotionMethod, goal_motion, SKYBODY_CONST_STATE, Values<Real>);
#undef SKYBODY_CONST_STATE
#undef SKYBODY_STATE
#undef SKYBODY_PLUGIN_METHOD

template <class Method, class T, class Real, class List>
struct Callable;
template <class Method, class T, class Real, class... Arguments>
struct Callable<Method, T, Real, TypeList<Arguments...>> {
  using State = typename Method::template State<T, Real>;
  static constexpr bool kPlain =
      requires(const T& t, const EnvView<Real>& e, State s, Arguments... a) {
    Method::call(t, e, s, a...);
  };
  static constexpr bool kWithBuffer =
      requires(const T& t, const EnvView<Real>& e, State s, Values<Real> b, Arguments... a) {
    Method::call(t, e, s, a..., b);
  };
};
template <class Method, class T, class Real>
using CallableOn = Callable<Method, T, Real, typename Method::template Arguments<Real>>;

/// Whether the class has the method for this Real.
template <class Method, class T, class Real>
inline constexpr bool kHas =
    CallableOn<Method, T, Real>::kPlain || CallableOn<Method, T, Real>::kWithBuffer;

/// Whether the class has the method for the packs of every instruction set.
template <class Method, class T, class Widths = PackWidths>
inline constexpr bool kHasInPacks = false;
template <class Method, class T, int... W>
inline constexpr bool kHasInPacks<Method, T, std::integer_sequence<int, W...>> =
    (kHas<Method, T, Pack<W>> && ...);

template <class Method, class T>
struct WithNamesake : T, Method::Namesake {};
/// Whether the class has any member of the method's name.
template <class Method, class T>
inline constexpr bool kIsNamed = !Method::template kNamesOneThing<WithNamesake<Method, T>>;

/// Calls the method, with the buffer if it takes one.
template <class Method, class T, class Real, class State, class... Arguments>
inline void call(const T& t, const EnvView<Real>& e, State& s, const Values<Real>& buffer,
                 Arguments&&... a) {
  if constexpr (CallableOn<Method, T, Real>::kWithBuffer) {
    Method::call(t, e, s, a..., buffer);
  } else {
    Method::call(t, e, s, a...);
  }
}

template <SkybodyKind>
struct StepMethodOf;
template <>
struct StepMethodOf<SKYBODY_CONTROLLER> {
  using type = ControlMethod;
};
template <>
struct StepMethodOf<SKYBODY_SENSOR> {
  using type = SenseMethod;
};
template <>
struct StepMethodOf<SKYBODY_RANDOMIZER> {
  using type = RandomizeMethod;
};
template <>
struct StepMethodOf<SKYBODY_TASK> {
  using type = EvaluateMethod;
};
template <>
struct StepMethodOf<SKYBODY_EFFECT> {
  using type = ApplyMethod;
};
/// The step method that a class of its kind must have.
template <class T>
using StepMethod = typename StepMethodOf<T::kKind>::type;

template <class T, bool = HasStateTemplate<T>>
inline constexpr bool kVectorizedImpl = kHasInPacks<StepMethod<T>, T>;
template <class T>
inline constexpr bool kVectorizedImpl<T, false> = false;
/// Whether the class serves several lanes at once, in packs of every width that the kernels use.
/// Otherwise it serves lane by lane.
template <class T>
inline constexpr bool kVectorized = kVectorizedImpl<T>;

/// Whether an optional method of the right name also has the right signature: for double, and for
/// packs if the step method has one.
template <class Method, class T, bool kInPacks = kVectorized<T>>
constexpr bool is_sound() {
  if constexpr (!kIsNamed<Method, T>) {
    return true;
  } else if constexpr (kInPacks) {
    return kHas<Method, T, double> && kHasInPacks<Method, T>;
  } else {
    return kHas<Method, T, double>;
  }
}

/// Compile-time checks of a plugin class.
template <class T>
constexpr void check_class() {
  static_assert(std::is_base_of_v<Plugin, T>,
                "derive from skybody::Controller, Sensor, Randomizer, Task or Effect");
  static_assert(!std::is_abstract_v<T>,
                "define `void configure(const skybody::Setup& setup) override`");
  static_assert(std::is_default_constructible_v<T>, "a plugin class needs a default constructor");
  constexpr bool kSteps = kHas<StepMethod<T>, T, double>;
  static_assert(
      T::kKind != SKYBODY_CONTROLLER || kSteps,
      "a controller needs `void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> "
      "input, Values<Real> output) const`, public and const");
  static_assert(
      T::kKind != SKYBODY_SENSOR || kSteps,
      "a sensor needs `void sense(const EnvView<Real>&, State<Real>&, Values<Real> output) "
      "const`, public and const");
  static_assert(T::kKind != SKYBODY_RANDOMIZER || kSteps,
                "a randomizer needs `void randomize(const EnvView<Real>&, State<Real>&, "
                "Start<Real>&) const`, public and const");
  static_assert(
      T::kKind != SKYBODY_TASK || kSteps,
      "a task needs `void evaluate(const EnvView<Real>&, State<Real>&, Evaluation<Real>&) "
      "const`, public and const");
  static_assert(T::kKind != SKYBODY_EFFECT || kSteps,
                "an effect needs `void apply(const EnvView<Real>&, State<Real>&, Held<Real>&) "
                "const`, public and const");
  static_assert(!T::kSmooth || T::kKind == SKYBODY_CONTROLLER || T::kKind == SKYBODY_EFFECT ||
                    T::kKind == SKYBODY_TASK,
                "kSmooth is for controllers, effects and tasks: leave it out");
  static_assert(!T::kSmooth || kVectorized<T>,
                "kSmooth needs a step method that is a template on Real: write it so, or leave "
                "kSmooth out");
  static_assert(
      is_sound<ResetMethod, T>(),
      "reset() must be `void reset(const EnvView<Real>&, State<Real>&) const`, public and "
      "const; a template on Real if the step method is one");
  if constexpr (T::kKind == SKYBODY_TASK) {
    static_assert(is_sound<ProcessMethod, T>(),
                  "process() must be `void process(const EnvView<Real>&, State<Real>&, "
                  "ConstValues<Real> action, Values<Real> command) const`, public and const; a "
                  "template on Real if evaluate() is one");
    static_assert(is_sound<RandomizeMethod, T>(),
                  "randomize() of a task must be `void randomize(const EnvView<Real>&, "
                  "State<Real>&, Start<Real>&) const`, public and const; a template on Real if "
                  "evaluate() is one");
    static_assert(is_sound<GoalMethod, T, false>(),
                  "goal() must be `void goal(const EnvView<double>&, const State<double>&, "
                  "Values<double> goal) const`, public and const");
    static_assert(is_sound<GoalMotionMethod, T, false>(),
                  "goal_motion() must be `void goal_motion(const EnvView<double>&, const "
                  "State<double>&, Values<double> motion) const`, public and const");
  }
}

}  // namespace skybody::plugin_export
