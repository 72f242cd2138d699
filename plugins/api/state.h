// How a plugin's State lies in WorldState, and which methods a plugin class has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "plugins/api/plugin.h"

namespace skybody::plugin_export {

// --- State ---------------------------------------------------------------------------------------

template <class T>
concept HasStateTemplate = requires { typename T::template State<double>; };

template <class T, class Real, bool = HasStateTemplate<T>>
struct StateOfImpl {
  using type = typename T::template State<Real>;
};
template <class T, class Real>
struct StateOfImpl<T, Real, false> {
  static_assert(std::is_same_v<Real, double>, "a plain State belongs to a plugin written for double");
  using type = typename T::State;
};
/// The class's State for `Real`: its template, or its plain struct for double.
template <class T, class Real>
using StateOf = typename StateOfImpl<T, Real>::type;

template <class T>
inline constexpr std::uint32_t kStateWords =
    std::is_empty_v<StateOf<T, double>> ? 0u
                                        : static_cast<std::uint32_t>(sizeof(StateOf<T, double>) / 8);

/// Compile-time checks of a State: only 64-bit words, the same number for every Real.
template <class T>
constexpr void check_state() {
  using Scalar = StateOf<T, double>;
  static_assert(std::is_trivially_copyable_v<Scalar>,
                "State must hold plain values: Real, Word<Real>, Vec3<Real>, Quat<Real>, arrays of them");
  static_assert(std::is_empty_v<Scalar> || (sizeof(Scalar) % 8 == 0 && alignof(Scalar) == 8),
                "State must consist of 64-bit words: use Real or Word<Real>, not int, bool or float");
  if constexpr (HasStateTemplate<T> && !std::is_empty_v<Scalar>) {
    static_assert(sizeof(StateOf<T, Pack<2>>) == 2 * sizeof(Scalar) &&
                      sizeof(StateOf<T, Pack<4>>) == 4 * sizeof(Scalar) &&
                      sizeof(StateOf<T, Pack<8>>) == 8 * sizeof(Scalar),
                  "every member of State must be Real or Word<Real> (or a Vec3, Quat or array of them), "
                  "so that it has one 64-bit word per environment");
  }
}

/// Gathers a State from words in lanes (stride words apart).
template <class Real, class State>
inline void load_state(State& state, const std::uint64_t* words,
                                              std::size_t stride) {
  if constexpr (!std::is_empty_v<State>) {
    constexpr std::size_t kCount = sizeof(State) / (8 * kLanesOf<Real>);
    auto* bytes = reinterpret_cast<unsigned char*>(&state);
    for (std::size_t i = 0; i < kCount; ++i) {
      const Word<Real> word = load_words<Real>(words + i * stride);
      std::memcpy(bytes + i * sizeof(word), &word, sizeof(word));
    }
  }
}

/// Puts a State back, for the lanes of `mask`.
template <class Real, class State>
inline void store_state(const State& state, std::uint64_t* words,
                                               std::size_t stride, MaskOf<Real> mask) {
  if constexpr (!std::is_empty_v<State>) {
    constexpr std::size_t kCount = sizeof(State) / (8 * kLanesOf<Real>);
    const auto* bytes = reinterpret_cast<const unsigned char*>(&state);
    for (std::size_t i = 0; i < kCount; ++i) {
      Word<Real> word;
      std::memcpy(&word, bytes + i * sizeof(word), sizeof(word));
      std::uint64_t* place = words + i * stride;
      store_words(place, select(mask, word, load_words<Real>(place)));
    }
  }
}

// --- Methods -------------------------------------------------------------------------------------

template <class Env>
struct RealOfImpl;
template <class Real>
struct RealOfImpl<Lanes<Real>> {
  using type = Real;
};
/// The Real of a `const Lanes<Real>&`.
template <class Env>
using RealOf = typename RealOfImpl<std::remove_cvref_t<Env>>::type;

template <class T, class Real>
concept CanReset = requires(const T& t, const Lanes<Real>& e, StateOf<T, Real>& s) { t.reset(e, s); };
template <class T, class Real>
concept CanResetBuffer =
    requires(const T& t, const Lanes<Real>& e, StateOf<T, Real>& s, Values<Real> b) { t.reset(e, s, b); };
template <class T, class Real>
concept CanControl = requires(const T& t, const Lanes<Real>& e, StateOf<T, Real>& s,
                              ConstValues<Real> i, Values<Real> o) { t.control(e, s, i, o); };
template <class T, class Real>
concept CanControlBuffer =
    requires(const T& t, const Lanes<Real>& e, StateOf<T, Real>& s, ConstValues<Real> i, Values<Real> o,
             Values<Real> b) { t.control(e, s, i, o, b); };
template <class T, class Real>
concept CanSense = requires(const T& t, const Lanes<Real>& e, StateOf<T, Real>& s, Values<Real> o) {
  t.sense(e, s, o);
};
template <class T, class Real>
concept CanSenseBuffer = requires(const T& t, const Lanes<Real>& e, StateOf<T, Real>& s, Values<Real> o,
                                  Values<Real> b) { t.sense(e, s, o, b); };
template <class T, class Real>
concept CanRandomize = requires(const T& t, const Lanes<Real>& e, StateOf<T, Real>& s,
                                Start<Real>& start) { t.randomize(e, s, start); };
template <class T, class Real>
concept CanEvaluate = requires(const T& t, const Lanes<Real>& e, StateOf<T, Real>& s,
                               Evaluation<Real>& o) { t.evaluate(e, s, o); };
template <class T, class Real>
concept CanEvaluateBuffer =
    requires(const T& t, const Lanes<Real>& e, StateOf<T, Real>& s, Evaluation<Real>& o,
             Values<Real> b) { t.evaluate(e, s, o, b); };

/// Has the class the step method of its kind for this Real?
template <class T, class Real>
inline constexpr bool kCanStep =
    T::kKind == SKYBODY_CONTROLLER   ? CanControl<T, Real> || CanControlBuffer<T, Real>
    : T::kKind == SKYBODY_SENSOR     ? CanSense<T, Real> || CanSenseBuffer<T, Real>
    : T::kKind == SKYBODY_RANDOMIZER ? CanRandomize<T, Real>
                                     : CanEvaluate<T, Real> || CanEvaluateBuffer<T, Real>;

template <class T, bool = HasStateTemplate<T>>
inline constexpr bool kVectorizedImpl = kCanStep<T, Pack<4>>;
template <class T>
inline constexpr bool kVectorizedImpl<T, false> = false;
/// Serves several lanes at a time. Otherwise lane after lane.
template <class T>
inline constexpr bool kVectorized = kVectorizedImpl<T>;

template <class T>
inline constexpr bool kHasReset = CanReset<T, double> || CanResetBuffer<T, double>;
template <class T>
inline constexpr bool kHasProcess =
    requires(const T& t, const Lanes<double>& e, StateOf<T, double>& s, ConstValues<double> a,
             Values<double> c) { t.process(e, s, a, c); };
template <class T>
inline constexpr bool kHasGoal = requires(const T& t, const Lanes<double>& e,
                                          const StateOf<T, double>& s,
                                          Values<double> g) { t.goal(e, s, g); };

template <class Real_mask>
struct RealOfMask;
template <>
struct RealOfMask<bool> {
  using type = double;
};
template <int W>
struct RealOfMask<Mask<W>> {
  using type = Pack<W>;
};

template <class M>
inline auto view(double* p, const SkybodyLanes& l, std::uint32_t first, M mask) {
  return Values<typename RealOfMask<M>::type>(p + first, l.lanes, mask);
}
template <class M>
inline auto const_view(const double* p, const SkybodyLanes& l, std::uint32_t first,
                                              M) {
  return ConstValues<typename RealOfMask<M>::type>(p + first, l.lanes);
}

template <class T, class Real, class S>
inline void call_reset(const T& t, const Lanes<Real>& e, S& s, Values<Real> b) {
  if constexpr (CanResetBuffer<T, Real>) {
    t.reset(e, s, b);
  } else {
    t.reset(e, s);
  }
}
template <class T, class Real, class S>
inline void call_control(const T& t, const Lanes<Real>& e, S& s,
                                                ConstValues<Real> i, Values<Real> o, Values<Real> b) {
  if constexpr (CanControlBuffer<T, Real>) {
    t.control(e, s, i, o, b);
  } else {
    t.control(e, s, i, o);
  }
}
template <class T, class Real, class S>
inline void call_sense(const T& t, const Lanes<Real>& e, S& s, Values<Real> o,
                                              Values<Real> b) {
  if constexpr (CanSenseBuffer<T, Real>) {
    t.sense(e, s, o, b);
  } else {
    t.sense(e, s, o);
  }
}
template <class T, class Real, class S>
inline void call_evaluate(const T& t, const Lanes<Real>& e, S& s,
                                                 Evaluation<Real>& o, Values<Real> b) {
  if constexpr (CanEvaluateBuffer<T, Real>) {
    t.evaluate(e, s, o, b);
  } else {
    t.evaluate(e, s, o);
  }
}

}  // namespace skybody::plugin_export
