// The step functions of a plugin class, for every instruction set.
//
// Each step method is compiled for double and for packs as wide as the vectors of an instruction
// set (core/base/simd/kernels.h); those of smooth classes (Plugin::kSmooth) also for packs of dual
// numbers. `flatten` inlines the author's code into functions of that target. The arithmetic is the
// same everywhere, so all targets give the same bits.
//
// None of the functions below is always_inline. g++ inlines into a flattened function only
// functions that it has already processed, and it does not look through always_inline functions
// when it orders them. With always_inline the author's code would stay a separate function,
// compiled for the baseline. tests/unit/plugins/codegen_test.cpp checks this.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/base/simd/kernels.h"
#include "plugins/api/methods.h"
#include "plugins/api/plugin.h"
#include "plugins/api/state.h"

namespace skybody::plugin_export {

/// Calls `function(env, state, first, mask)` for the active lanes in [first, first + lanes of
/// Real). Loads the state before the call and stores it after.
/// @param width  lanes of the group
template <class T, class Real, class Function>
inline void serve(const SkybodyLanes& lanes, std::uint32_t width, std::uint32_t first,
                  std::uint64_t* words, Function&& function) {
  const std::uint32_t bits = (lanes.active >> first) & ((1u << kLanesOf<Real>)-1u);
  if (bits == 0) return;
  const MaskOf<Real> mask = mask_from_bits<Real>(bits);
  const EnvView<Real> env(lanes, width, first, mask);
  StateOf<T, Real> state;
  load_state<T, Real>(state, words, first, width);
  function(env, state, first, mask);
  store_state<T, Real>(state, words, first, width, mask);
}

/// Serves a full group, kLanesOf<Real> lanes at a time.
template <class T, class Real, class Function>
inline void serve_all(const SkybodyLanes& lanes, std::uint64_t* words, Function&& function) {
  for (std::uint32_t first = 0; first < SKYBODY_GROUP_LANES; first += kLanesOf<Real>) {
    serve<T, Real>(lanes, SKYBODY_GROUP_LANES, first, words, function);
  }
}

/// Serves a group: in packs if the class has lane code and the group is full, otherwise lane by
/// lane. Groups of dual numbers are always full.
template <class T, SkybodyNumber N, int W, class Function>
inline void for_lanes(const SkybodyLanes& lanes, std::uint64_t* words, Function&& function) {
  if constexpr (N == SKYBODY_NUMBER_DUAL) {
    serve_all<T, Dual<Pack<W>>>(lanes, words, function);
  } else {
    if constexpr (kVectorized<T>) {
      if (lanes.lanes == SKYBODY_GROUP_LANES) {
        serve_all<T, Pack<W>>(lanes, words, function);
        return;
      }
    }
    for (std::uint32_t first = 0; first < lanes.lanes; ++first) {
      serve<T, double>(lanes, lanes.lanes, first, words, function);
    }
  }
}

/// The views passed to step methods, with their names and sizes for checked mode.
struct Views {
  template <class Env, class Mask>
  static auto buffer(const Env& env, double* p, std::uint32_t first, const Mask& mask) {
    return env.values(p, first, mask, "buffer", [](const SkybodyChecks& c) { return c.buffer; });
  }
  template <class Env>
  static auto input(const Env& env, const double* p, std::uint32_t first) {
    return env.const_values(p, first, "input", [](const SkybodyChecks& c) { return c.input; });
  }
  template <class Env, class Mask>
  static auto output(const Env& env, double* p, std::uint32_t first, const Mask& mask) {
    return env.values(p, first, mask, "output", [](const SkybodyChecks& c) { return c.output; });
  }
  template <class Env, class Mask>
  static auto info(const Env& env, double* p, std::uint32_t first, const Mask& mask) {
    return env.values(p, first, mask, "info", [](const SkybodyChecks& c) { return c.info; });
  }
  template <class Env, class Mask>
  static auto robots(const Env& env, double* p, std::uint32_t first, const Mask& mask) {
    return env.values(p, first, mask, "robot reward",
                      [](const SkybodyChecks& c) { return c.robots; });
  }
  template <class Env, class Mask>
  static auto one(const Env& env, double* p, std::uint32_t first, const Mask& mask) {
    return env.values(p, first, mask, "reward", [](const SkybodyChecks&) { return 1; });
  }
  template <class Env, class Mask>
  static auto start(const Env& env, const SkybodyStart& s, std::uint32_t first, const Mask& mask) {
    return Start<RealOf<Env>>(
        env.values(s.q, first, mask, "q", [](const SkybodyChecks& c) { return c.q; }),
        env.values(s.u, first, mask, "u", [](const SkybodyChecks& c) { return c.u; }),
        env.values(s.rotor_speed, first, mask, "rotor",
                   [](const SkybodyChecks& c) { return c.rotors; }),
        env.values(s.params, first, mask, "param", [](const SkybodyChecks& c) { return c.params; }),
        s.occasion);
  }
};

/// Casts `p` to the instance of plugin class T.
template <class T>
const T& self(const void* p) {
  return *static_cast<const T*>(p);
}

// The functions of SkybodyKernels for one class and one type of number. W: lanes of a pack.

template <class T, SkybodyNumber N>
struct Reset {
  template <int W>
  static void run(const void* p, const SkybodyLanes* l, std::uint64_t* s, double* buffer) {
    for_lanes<T, N, W>(*l, s, [&](const auto& env, auto& state, std::uint32_t first, auto mask) {
      call<ResetMethod>(self<T>(p), env, state, Views::buffer(env, buffer, first, mask));
    });
  }
};

template <class T, SkybodyNumber N>
struct Control {
  template <int W>
  static void run(const void* p, const SkybodyLanes* l, std::uint64_t* s, double* buffer,
                  const double* in, double* out) {
    for_lanes<T, N, W>(*l, s, [&](const auto& env, auto& state, std::uint32_t first, auto mask) {
      const decltype(mask) all(true);  // the host's scratch memory: other lanes may be overwritten
      call<ControlMethod>(self<T>(p), env, state, Views::buffer(env, buffer, first, mask),
                          Views::input(env, in, first), Views::output(env, out, first, all));
    });
  }
};

template <class T, SkybodyNumber N>
struct Sense {
  template <int W>
  static void run(const void* p, const SkybodyLanes* l, std::uint64_t* s, double* buffer,
                  double* out) {
    for_lanes<T, N, W>(*l, s, [&](const auto& env, auto& state, std::uint32_t first, auto mask) {
      call<SenseMethod>(self<T>(p), env, state, Views::buffer(env, buffer, first, mask),
                        Views::output(env, out, first, mask));
    });
  }
};

template <class T, SkybodyNumber N>
struct Randomize {
  template <int W>
  static void run(const void* p, const SkybodyLanes* l, std::uint64_t* s, double* buffer,
                  const SkybodyStart* start) {
    for_lanes<T, N, W>(*l, s, [&](const auto& env, auto& state, std::uint32_t first, auto mask) {
      auto where = Views::start(env, *start, first, mask);
      call<RandomizeMethod>(self<T>(p), env, state, Views::buffer(env, buffer, first, mask), where);
    });
  }
};

template <class T, SkybodyNumber N>
struct Apply {
  template <int W>
  static void run(const void* p, const SkybodyLanes* l, std::uint64_t* s, double* buffer,
                  const SkybodyHeld* held) {
    for_lanes<T, N, W>(*l, s, [&](const auto& env, auto& state, std::uint32_t first, auto mask) {
      Held<RealOf<decltype(env)>> inputs(*held, *l, env.lanes(), first, mask);
      call<ApplyMethod>(self<T>(p), env, state, Views::buffer(env, buffer, first, mask), inputs);
    });
  }
};

template <class T, SkybodyNumber N>
struct Process {
  template <int W>
  static void run(const void* p, const SkybodyLanes* l, std::uint64_t* s, double* buffer,
                  const double* action, double* command) {
    for_lanes<T, N, W>(*l, s, [&](const auto& env, auto& state, std::uint32_t first, auto mask) {
      call<ProcessMethod>(self<T>(p), env, state, Views::buffer(env, buffer, first, mask),
                          Views::input(env, action, first),
                          Views::output(env, command, first, mask));
    });
  }
};

template <class T, SkybodyNumber N>
struct Evaluate {
  template <int W>
  static void run(const void* p, const SkybodyLanes* l, std::uint64_t* s, double* buffer,
                  const SkybodyEvaluation* result) {
    for_lanes<T, N, W>(*l, s, [&](const auto& env, auto& state, std::uint32_t first, auto mask) {
      const decltype(mask) all(true);  // the host's scratch memory: other lanes may be overwritten
      Evaluation<RealOf<decltype(env)>> out(Views::output(env, result->observation, first, all),
                                            Views::info(env, result->info, first, all),
                                            Views::one(env, result->reward, first, all),
                                            Views::robots(env, result->robot_reward, first, all),
                                            result->end + first, mask, result->wants_info != 0);
      call<EvaluateMethod>(self<T>(p), env, state, Views::buffer(env, buffer, first, mask), out);
    });
  }
};

/// goal() or goal_motion(): lane by lane on every instruction set. Only reads the state: a goal can
/// be requested at any time.
template <class Method, class T>
void goal(const void* p, const SkybodyLanes* l, const std::uint64_t* s, const double* buffer,
          double* goal) {
  for (std::uint32_t first = 0; first < l->lanes; ++first) {
    if (((l->active >> first) & 1u) == 0) continue;
    const EnvView<double> env(*l, l->lanes, first, true);
    StateOf<T, double> state;
    load_state<T, double>(state, s, first, l->lanes);
    call<Method>(self<T>(p), env, std::as_const(state),
                 Views::buffer(env, const_cast<double*>(buffer), first, false),
                 Views::output(env, goal, first, true));
  }
}

/// The functions of a class for one number type. Only smooth classes have functions on dual
/// numbers.
template <class T, SkybodyNumber N>
constexpr SkybodyKernels kernels_of(Isa isa) {
  SkybodyKernels k{};
  if constexpr (N == SKYBODY_NUMBER_REAL || T::kSmooth) {
    if constexpr (kHas<ResetMethod, T, double>) k.reset = kernel<Reset<T, N>>(isa);
    if constexpr (T::kKind == SKYBODY_CONTROLLER) k.control = kernel<Control<T, N>>(isa);
    if constexpr (T::kKind == SKYBODY_SENSOR) k.sense = kernel<Sense<T, N>>(isa);
    if constexpr (T::kKind == SKYBODY_RANDOMIZER) k.randomize = kernel<Randomize<T, N>>(isa);
    if constexpr (T::kKind == SKYBODY_EFFECT) k.apply = kernel<Apply<T, N>>(isa);
    if constexpr (T::kKind == SKYBODY_TASK) {
      k.evaluate = kernel<Evaluate<T, N>>(isa);
      if constexpr (kHas<ProcessMethod, T, double>) k.process = kernel<Process<T, N>>(isa);
      if constexpr (N == SKYBODY_NUMBER_REAL && kHas<RandomizeMethod, T, double>) {
        k.randomize = kernel<Randomize<T, N>>(isa);
      }
      if constexpr (N == SKYBODY_NUMBER_REAL && kHas<GoalMethod, T, double>)
        k.goal = &goal<GoalMethod, T>;
      if constexpr (N == SKYBODY_NUMBER_REAL && kHas<GoalMotionMethod, T, double>) {
        k.goal_motion = &goal<GoalMotionMethod, T>;
      }
    }
  }
  return k;
}

}  // namespace skybody::plugin_export
