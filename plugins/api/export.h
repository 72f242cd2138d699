// Builds the C descriptor of a plugin class: SKYBODY_PLUGIN(Class, "name", "version", "one line").
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "core/base/simd/fp_environment.h"
#include "core/plugin_abi/structures.h"
#include "plugins/api/kernels.h"
#include "plugins/api/methods.h"
#include "plugins/api/plugin.h"
#include "plugins/api/state.h"

namespace skybody::plugin_export {

/// Creates, binds and configures an instance; turns exceptions into a message.
template <class T>
void* create(const SkybodySetup* setup, const SkybodyDeclare* declare, char* error,
             std::size_t error_size) noexcept {
  try {
    auto instance = std::make_unique<T>();
    const auto& parameters = instance->parameters();
    if (setup->value_count != static_cast<int>(parameters.size())) {
      throw std::logic_error("the host gave " + std::to_string(setup->value_count) +
                             " parameter values instead of " + std::to_string(parameters.size()));
    }
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
  Description(const char* name, const char* version, const char* doc) noexcept {
    check_class<T>();
    check_state<T>();
    try {
      prototype_ = std::make_unique<T>();
      for (const Parameter* p : prototype_->parameters()) parameters_.push_back(p->declaration());
    } catch (const std::exception& e) {
      std::snprintf(failure_, sizeof failure_, "%s", e.what());
    } catch (...) {
      std::snprintf(failure_, sizeof failure_, "threw something that is no std::exception");
    }
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
    for (int i = 0; i < kIsaCount; ++i) {
      plugin_.kernels[SKYBODY_NUMBER_REAL][i] =
          kernels_of<T, SKYBODY_NUMBER_REAL>(static_cast<Isa>(i));
      plugin_.kernels[SKYBODY_NUMBER_DUAL][i] =
          kernels_of<T, SKYBODY_NUMBER_DUAL>(static_cast<Isa>(i));
    }
  }
  Description(const Description&) = delete;
  Description& operator=(const Description&) = delete;

  const SkybodyPlugin* plugin() const { return &plugin_; }
  /// Message of the exception from the class's constructor, or nullptr.
  const char* failure() const { return failure_[0] != '\0' ? failure_ : nullptr; }

 private:
  std::unique_ptr<T> prototype_;
  std::vector<SkybodyParameter> parameters_;
  SkybodyPlugin plugin_{};
  char failure_[512] = {};
};

/// The exported object. `probe` comes from the author's own file, compiled with its flags.
inline SkybodyPluginLibrary library(const SkybodyPlugin* const* plugins, std::uint32_t count,
                                    const char* failure, std::uint64_t (*probe)()) {
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
  l.structures = structures_hash();
  l.fp_probe = probe;
  l.plugins = plugins;
  l.plugin_count = count;
  l.failure = failure;
  return l;
}

}  // namespace skybody::plugin_export

/// Exports one plugin class from a shared library. Use once per library, at file scope, outside of
/// namespaces:
///   SKYBODY_PLUGIN(RateFilter, "rate_filter", "1.0.0", "Filters body rates.");
#define SKYBODY_PLUGIN(CLASS, NAME, VERSION, DOC)                                           \
  namespace {                                                                               \
  const skybody::plugin_export::Description<CLASS> skybody_description(NAME, VERSION, DOC); \
  const SkybodyPlugin* const skybody_plugins[] = {skybody_description.plugin()};            \
  }                                                                                         \
  extern "C" __attribute__((visibility("default"), used))                                   \
  const SkybodyPluginLibrary skybody_plugin_library = skybody::plugin_export::library(      \
      skybody_plugins, 1, skybody_description.failure(), &skybody::fp_probe)
