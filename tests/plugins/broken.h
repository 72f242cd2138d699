// A valid plugin library with one change. The libraries that must be refused are built from it.
#pragma once

#include <skybody/plugin.h>

#include <vector>

namespace {

/// The smallest valid controller.
class Idle : public skybody::Controller {
 public:
  void configure(const skybody::Setup&) override {}
  void control(const skybody::EnvView<double>&, State<double>&, skybody::ConstValues<double>,
               skybody::Values<double>) const {}
};

}  // namespace

/// Exports plugin NAME after the statement CHANGE, which may alter `plugin` and `library`.
#define SKYBODY_BROKEN_PLUGIN(NAME, CHANGE)                                                    \
  namespace {                                                                                  \
  const skybody::plugin_export::Description<Idle> description(NAME, "1.0.0", "Does nothing."); \
  SkybodyPlugin plugin = *description.plugin();                                                \
  const SkybodyPlugin* const plugins[] = {&plugin};                                            \
  SkybodyPluginLibrary changed() {                                                             \
    SkybodyPluginLibrary library =                                                             \
        skybody::plugin_export::library(plugins, 1, nullptr, &skybody::fp_probe);              \
    CHANGE;                                                                                    \
    return library;                                                                            \
  }                                                                                            \
  }                                                                                            \
  extern "C" __attribute__((visibility("default"), used))                                      \
  const SkybodyPluginLibrary skybody_plugin_library = changed()
