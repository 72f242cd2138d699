// Which step methods a plugin class has, for which Real, and how they are called. Every method may
// take the instance's buffer as one more argument.
#pragma once

#include <type_traits>

#include "core/base/kernels.h"
#include "plugins/api/plugin.h"
#include "plugins/api/state.h"

namespace skybody::plugin_export {

template <class Env>
struct RealOfImpl;
template <class Real>
struct RealOfImpl<Lanes<Real>> {
  using type = Real;
};
/// The Real of a `const Lanes<Real>&`.
template <class Env>
using RealOf = typename RealOfImpl<std::remove_cvref_t<Env>>::type;

template <class T, class Real, class... Buffer>
concept CanReset = requires(const T& t, const Lanes<Real>& e, StateOf<T, Real>& s, Buffer... b) {
  t.reset(e, s, b...);
};
template <class T, class Real, class... Buffer>
concept CanControl = requires(const T& t, const Lanes<Real>& e, StateOf<T, Real>& s,
                              ConstValues<Real> input, Values<Real> output, Buffer... b) {
  t.control(e, s, input, output, b...);
};
template <class T, class Real, class... Buffer>
concept CanSense = requires(const T& t, const Lanes<Real>& e, StateOf<T, Real>& s,
                            Values<Real> output, Buffer... b) {
  t.sense(e, s, output, b...);
};
template <class T, class Real, class... Buffer>
concept CanRandomize = requires(const T& t, const Lanes<Real>& e, StateOf<T, Real>& s,
                                Start<Real>& start, Buffer... b) {
  t.randomize(e, s, start, b...);
};
template <class T, class Real, class... Buffer>
concept CanProcess = requires(const T& t, const Lanes<Real>& e, StateOf<T, Real>& s,
                              ConstValues<Real> action, Values<Real> command, Buffer... b) {
  t.process(e, s, action, command, b...);
};
template <class T, class Real, class... Buffer>
concept CanEvaluate = requires(const T& t, const Lanes<Real>& e, StateOf<T, Real>& s,
                               Evaluation<Real>& out, Buffer... b) {
  t.evaluate(e, s, out, b...);
};

template <class T, class Real>
inline constexpr bool kHasReset = CanReset<T, Real> || CanReset<T, Real, Values<Real>>;
template <class T, class Real>
inline constexpr bool kHasProcess = CanProcess<T, Real> || CanProcess<T, Real, Values<Real>>;
template <class T>
inline constexpr bool kHasGoal = requires(const T& t, const Lanes<double>& e,
                                          const StateOf<T, double>& s, Values<double> g) {
  t.goal(e, s, g);
};

/// Has the class the step method of its kind for this Real?
template <class T, class Real>
inline constexpr bool kCanStep =
    T::kKind == SKYBODY_CONTROLLER   ? CanControl<T, Real> || CanControl<T, Real, Values<Real>>
    : T::kKind == SKYBODY_SENSOR     ? CanSense<T, Real> || CanSense<T, Real, Values<Real>>
    : T::kKind == SKYBODY_RANDOMIZER ? CanRandomize<T, Real> || CanRandomize<T, Real, Values<Real>>
                                     : CanEvaluate<T, Real> || CanEvaluate<T, Real, Values<Real>>;

/// The same for the packs of every instruction set.
template <class T, class Widths = PackWidths>
struct InPacks;
template <class T, int... W>
struct InPacks<T, std::integer_sequence<int, W...>> {
  static constexpr bool kStep = (kCanStep<T, Pack<W>> && ...);
  static constexpr bool kReset = (kHasReset<T, Pack<W>> && ...);
  static constexpr bool kProcess = (kHasProcess<T, Pack<W>> && ...);
};

template <class T, bool = HasStateTemplate<T>>
inline constexpr bool kVectorizedImpl = InPacks<T>::kStep;
template <class T>
inline constexpr bool kVectorizedImpl<T, false> = false;
/// Serves several lanes at a time, in packs of every width that the kernels use. Otherwise lane
/// after lane.
template <class T>
inline constexpr bool kVectorized = kVectorizedImpl<T>;

/// Compile-time checks of a plugin class.
template <class T>
constexpr void check_class() {
  static_assert(std::is_base_of_v<Plugin, T>,
                "derive from skybody::Controller, Sensor, Randomizer or Task");
  static_assert(!std::is_abstract_v<T>,
                "define `void configure(const skybody::Setup& setup) override`");
  static_assert(std::is_default_constructible_v<T>, "a plugin class needs a default constructor");
  static_assert(
      T::kKind != SKYBODY_CONTROLLER || kCanStep<T, double>,
      "a controller needs `void control(const Lanes<Real>&, State<Real>&, ConstValues<Real> "
      "input, Values<Real> output) const`, public and const");
  static_assert(T::kKind != SKYBODY_SENSOR || kCanStep<T, double>,
                "a sensor needs `void sense(const Lanes<Real>&, State<Real>&, Values<Real> output) "
                "const`, public and const");
  static_assert(
      T::kKind != SKYBODY_RANDOMIZER || kCanStep<T, double>,
      "a randomizer needs `void randomize(const Lanes<Real>&, State<Real>&, Start<Real>&) "
      "const`, public and const");
  static_assert(T::kKind != SKYBODY_TASK || kCanStep<T, double>,
                "a task needs `void evaluate(const Lanes<Real>&, State<Real>&, Evaluation<Real>&) "
                "const`, public and const");
  if constexpr (kVectorized<T>) {
    static_assert(
        !kHasReset<T, double> || InPacks<T>::kReset,
        "reset() is written for double, the step method for any Real: make both templates");
    static_assert(!kHasProcess<T, double> || InPacks<T>::kProcess,
                  "process() is written for double, evaluate() for any Real: make both templates");
  }
}

template <class T, class Real, class S>
inline void call_reset(const T& t, const Lanes<Real>& e, S& s, const Values<Real>& b) {
  if constexpr (CanReset<T, Real, Values<Real>>) {
    t.reset(e, s, b);
  } else {
    t.reset(e, s);
  }
}
template <class T, class Real, class S>
inline void call_control(const T& t, const Lanes<Real>& e, S& s, const ConstValues<Real>& input,
                         const Values<Real>& output, const Values<Real>& b) {
  if constexpr (CanControl<T, Real, Values<Real>>) {
    t.control(e, s, input, output, b);
  } else {
    t.control(e, s, input, output);
  }
}
template <class T, class Real, class S>
inline void call_sense(const T& t, const Lanes<Real>& e, S& s, const Values<Real>& output,
                       const Values<Real>& b) {
  if constexpr (CanSense<T, Real, Values<Real>>) {
    t.sense(e, s, output, b);
  } else {
    t.sense(e, s, output);
  }
}
template <class T, class Real, class S>
inline void call_randomize(const T& t, const Lanes<Real>& e, S& s, Start<Real>& start,
                           const Values<Real>& b) {
  if constexpr (CanRandomize<T, Real, Values<Real>>) {
    t.randomize(e, s, start, b);
  } else {
    t.randomize(e, s, start);
  }
}
template <class T, class Real, class S>
inline void call_process(const T& t, const Lanes<Real>& e, S& s, const ConstValues<Real>& action,
                         const Values<Real>& command, const Values<Real>& b) {
  if constexpr (CanProcess<T, Real, Values<Real>>) {
    t.process(e, s, action, command, b);
  } else {
    t.process(e, s, action, command);
  }
}
template <class T, class Real, class S>
inline void call_evaluate(const T& t, const Lanes<Real>& e, S& s, Evaluation<Real>& out,
                          const Values<Real>& b) {
  if constexpr (CanEvaluate<T, Real, Values<Real>>) {
    t.evaluate(e, s, out, b);
  } else {
    t.evaluate(e, s, out);
  }
}

}  // namespace skybody::plugin_export
