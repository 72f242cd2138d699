// From a plugin class to the C descriptor: SKYBODY_PLUGIN(Class, "name", "version", "one line").
//
// Each step method is compiled four times: for double, and for packs as wide as the vectors of
// x86-64-v2, v3 and v4. `flatten` pulls the author's code into functions of that target; the
// arithmetic is the same everywhere, so all give the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <type_traits>
#include <vector>

#include "core/base/fp_environment.h"
#include "plugins/api/plugin.h"
#include "plugins/api/state.h"

namespace skybody::plugin_export {

/// Calls `function(env, state, first, mask)` for every served block of lanes, with the state loaded
/// before and stored after.
template <class T, class Real, class Function>
inline void serve(const SkybodyLanes& lanes, std::uint32_t first,
                                         std::uint64_t* state_words, Function&& function) {
  using State = StateOf<T, Real>;
  const std::uint32_t bits = (lanes.active >> first) & ((1u << kLanesOf<Real>)-1u);
  if (bits == 0) return;
  const MaskOf<Real> mask = mask_from_bits<Real>(bits);
  const Lanes<Real> env(lanes, first, mask);
  State state;
  load_state<Real>(state, state_words + first, lanes.lanes);
  function(env, state, first, mask);
  store_state<Real>(state, state_words + first, lanes.lanes, mask);
}

/// Runs `Call::template run<Real>` over a group: packs where the class has lane code and the group
/// is wide enough, else double.
template <class T, int W, class Call>
inline void for_lanes(const SkybodyLanes& lanes, std::uint64_t* state,
                                             Call&& call) {
  if constexpr (kVectorized<T>) {
    if (lanes.lanes >= static_cast<std::uint32_t>(W)) {
      for (std::uint32_t first = 0; first < lanes.lanes; first += W) {
        serve<T, Pack<W>>(lanes, first, state, call);
      }
      return;
    }
  }
  for (std::uint32_t first = 0; first < lanes.lanes; ++first) {
    serve<T, double>(lanes, first, state, call);
  }
}

/// The step functions of one class, shared by the instruction sets.
template <class T, int W>
struct Steps {
  static const T& self(const void* p) { return *static_cast<const T*>(p); }

  static void reset(const void* p, const SkybodyLanes* l,
                                                  std::uint64_t* s, double* buffer) {
    for_lanes<T, W>(*l, s, [&](const auto& env, auto& state, std::uint32_t first, auto mask) {
      call_reset(self(p), env, state, view(buffer, *l, first, mask));
    });
  }
  static void control(const void* p, const SkybodyLanes* l,
                                                    std::uint64_t* s, double* buffer,
                                                    const double* in, double* out) {
    for_lanes<T, W>(*l, s, [&](const auto& env, auto& state, std::uint32_t first, auto mask) {
      call_control(self(p), env, state, const_view(in, *l, first, mask), view(out, *l, first, mask),
                   view(buffer, *l, first, mask));
    });
  }
  static void sense(const void* p, const SkybodyLanes* l,
                                                  std::uint64_t* s, double* buffer, double* out) {
    for_lanes<T, W>(*l, s, [&](const auto& env, auto& state, std::uint32_t first, auto mask) {
      call_sense(self(p), env, state, view(out, *l, first, mask), view(buffer, *l, first, mask));
    });
  }
  static void randomize(const void* p, const SkybodyLanes* l,
                                                      std::uint64_t* s, double*,
                                                      const SkybodyStart* start) {
    for_lanes<T, W>(*l, s, [&](const auto& env, auto& state, std::uint32_t first, auto mask) {
      Start<RealOf<decltype(env)>> where(*start, l->lanes, first, mask);
      self(p).randomize(env, state, where);
    });
  }
  static void process(const void* p, const SkybodyLanes* l,
                                                    std::uint64_t* s, double*, const double* action,
                                                    double* command) {
    for_lanes<T, W>(*l, s, [&](const auto& env, auto& state, std::uint32_t first, auto mask) {
      self(p).process(env, state, const_view(action, *l, first, mask),
                      view(command, *l, first, mask));
    });
  }
  static void evaluate(const void* p, const SkybodyLanes* l,
                                                     std::uint64_t* s, double* buffer,
                                                     const SkybodyEvaluation* result) {
    for_lanes<T, W>(*l, s, [&](const auto& env, auto& state, std::uint32_t first, auto mask) {
      Evaluation<RealOf<decltype(env)>> out(*result, l->lanes, first, mask);
      call_evaluate(self(p), env, state, out, view(buffer, *l, first, mask));
    });
  }
  /// Reads the state only: a goal can be asked for at any time.
  static void goal(const void* p, const SkybodyLanes* l,
                                                 const std::uint64_t* s, const double*,
                                                 double* goal) {
    for (std::uint32_t first = 0; first < l->lanes; ++first) {
      if (((l->active >> first) & 1u) == 0) continue;
      const Lanes<double> env(*l, first, true);
      StateOf<T, double> state;
      load_state<double>(state, s + first, l->lanes);
      self(p).goal(env, state, Values<double>(goal + first, l->lanes, true));
    }
  }
};

// One set of functions per instruction set. A macro, because the target is an attribute.
#define SKYBODY_KERNEL_SET(NAME, TARGET, WIDTH)                                                     \
  template <class T>                                                                                \
  struct NAME {                                                                                     \
    using S = Steps<T, WIDTH>;                                                                      \
    [[gnu::target(TARGET), gnu::flatten]] static void reset(                                        \
        const void* p, const SkybodyLanes* l, std::uint64_t* s, double* b) {                        \
      if constexpr (kHasReset<T>) S::reset(p, l, s, b);                                             \
    }                                                                                               \
    [[gnu::target(TARGET), gnu::flatten]] static void control(                                      \
        const void* p, const SkybodyLanes* l, std::uint64_t* s, double* b, const double* in,        \
        double* out) {                                                                              \
      if constexpr (T::kKind == SKYBODY_CONTROLLER) S::control(p, l, s, b, in, out);                \
    }                                                                                               \
    [[gnu::target(TARGET), gnu::flatten]] static void sense(                                        \
        const void* p, const SkybodyLanes* l, std::uint64_t* s, double* b, double* out) {           \
      if constexpr (T::kKind == SKYBODY_SENSOR) S::sense(p, l, s, b, out);                          \
    }                                                                                               \
    [[gnu::target(TARGET), gnu::flatten]] static void randomize(                                    \
        const void* p, const SkybodyLanes* l, std::uint64_t* s, double* b,                          \
        const SkybodyStart* start) {                                                                \
      if constexpr (T::kKind == SKYBODY_RANDOMIZER) S::randomize(p, l, s, b, start);                \
    }                                                                                               \
    [[gnu::target(TARGET), gnu::flatten]] static void process(                                      \
        const void* p, const SkybodyLanes* l, std::uint64_t* s, double* b, const double* action,    \
        double* command) {                                                                          \
      if constexpr (kHasProcess<T>) S::process(p, l, s, b, action, command);                        \
    }                                                                                               \
    [[gnu::target(TARGET), gnu::flatten]] static void evaluate(                                     \
        const void* p, const SkybodyLanes* l, std::uint64_t* s, double* b,                          \
        const SkybodyEvaluation* out) {                                                             \
      if constexpr (T::kKind == SKYBODY_TASK) S::evaluate(p, l, s, b, out);                         \
    }                                                                                               \
    static void goal(const void* p, const SkybodyLanes* l, const std::uint64_t* s, const double* b, \
                     double* out) {                                                                 \
      if constexpr (kHasGoal<T>) S::goal(p, l, s, b, out);                                          \
    }                                                                                               \
    static constexpr SkybodyKernels table() {                                                       \
      SkybodyKernels k{};                                                                           \
      if constexpr (kHasReset<T>) k.reset = &reset;                                                 \
      if constexpr (T::kKind == SKYBODY_CONTROLLER) k.control = &control;                           \
      if constexpr (T::kKind == SKYBODY_SENSOR) k.sense = &sense;                                   \
      if constexpr (T::kKind == SKYBODY_RANDOMIZER) k.randomize = &randomize;                       \
      if constexpr (kHasProcess<T>) k.process = &process;                                           \
      if constexpr (T::kKind == SKYBODY_TASK) k.evaluate = &evaluate;                               \
      if constexpr (kHasGoal<T>) k.goal = &goal;                                                    \
      return k;                                                                                     \
    }                                                                                               \
  }

SKYBODY_KERNEL_SET(KernelsV2, "arch=x86-64-v2", 2);
SKYBODY_KERNEL_SET(KernelsV3, "arch=x86-64-v3", 4);
SKYBODY_KERNEL_SET(KernelsV4, "arch=x86-64-v4", 8);
#undef SKYBODY_KERNEL_SET

/// Makes, binds and configures an instance; turns exceptions into a message.
template <class T>
void* create(const SkybodySetup* setup, const SkybodyDeclare* declare, char* error,
             std::size_t error_size) noexcept {
  try {
    auto instance = std::make_unique<T>();
    const auto& parameters = instance->parameters();
    for (std::size_t i = 0; i < parameters.size(); ++i) parameters[i]->bind(setup->values[i]);
    instance->set_stream(derive_stream(setup->instance));
    instance->configure(Setup(*setup, *declare));
    return instance.release();
  } catch (const std::exception& e) {
    std::snprintf(error, error_size, "%s", e.what());
  } catch (...) {
    std::snprintf(error, error_size, "threw something that is no std::exception");
  }
  return nullptr;
}

template <class T>
void destroy(void* self) noexcept {
  delete static_cast<T*>(self);
}

/// Descriptor and declarations of one class, built when the library is loaded.
template <class T>
class Description {
 public:
  Description(const char* name, const char* version, const char* doc) {
    check_state<T>();
    for (const Parameter* p : prototype_.parameters()) parameters_.push_back(p->declaration());
    plugin_.kind = T::kKind;
    plugin_.state_words = kStateWords<T>;
    plugin_.name = name;
    plugin_.version = version;
    plugin_.doc = doc;
    plugin_.parameters = parameters_.data();
    plugin_.parameter_count = static_cast<std::uint32_t>(parameters_.size());
    plugin_.vectorized = kVectorized<T> ? 1 : 0;
    plugin_.create = &create<T>;
    plugin_.destroy = &destroy<T>;
    plugin_.kernels[0] = KernelsV2<T>::table();
    plugin_.kernels[1] = KernelsV3<T>::table();
    plugin_.kernels[2] = KernelsV4<T>::table();
  }
  const SkybodyPlugin* plugin() const { return &plugin_; }

 private:
  T prototype_;
  std::vector<SkybodyParameter> parameters_;
  SkybodyPlugin plugin_{};
};

inline SkybodyPluginLibrary library(const SkybodyPlugin* const* plugins, std::uint32_t count) {
  SkybodyPluginLibrary l{};
  l.magic = SKYBODY_ABI_MAGIC;
  l.abi_version = SKYBODY_ABI_VERSION;
  l.library_size = sizeof(SkybodyPluginLibrary);
  l.plugin_size = sizeof(SkybodyPlugin);
  l.kernels_size = sizeof(SkybodyKernels);
  l.setup_size = sizeof(SkybodySetup);
  l.declare_size = sizeof(SkybodyDeclare);
  l.lanes_size = sizeof(SkybodyLanes);
  l.parameter_size = sizeof(SkybodyParameter);
  l.fp_probe = &fp_probe;
  l.plugins = plugins;
  l.plugin_count = count;
  return l;
}

}  // namespace skybody::plugin_export

/// Exports one plugin class from a shared library. Once per library.
#define SKYBODY_PLUGIN(CLASS, NAME, VERSION, DOC)                                              \
  namespace {                                                                                  \
  const skybody::plugin_export::Description<CLASS> skybody_description(NAME, VERSION, DOC);     \
  const SkybodyPlugin* const skybody_plugins[] = {skybody_description.plugin()};                \
  }                                                                                            \
  extern "C" __attribute__((visibility("default"), used))                                      \
  const SkybodyPluginLibrary skybody_plugin_library =                                          \
      skybody::plugin_export::library(skybody_plugins, 1)
