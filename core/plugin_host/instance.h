// Creates instances of plugins and selects their functions.
#pragma once

#include <memory>

#include "core/base/simd/isa.h"
#include "core/plugin_abi/abi.h"
#include "core/plugin_host/load_error.h"
#include "core/plugin_host/registry.h"

namespace skybody {

/// Creates and configures an instance of a usable plugin (entry.failure is empty). The instance
/// keeps its library loaded. The thread runs in Skybody's floating-point mode during the call and
/// in the caller's afterwards.
/// @throws PluginConfigureError with the plugin's own text if it refuses
/// @throws PluginLoadError      if the entry cannot be used
std::shared_ptr<const void> create_instance(const PluginEntry& entry, const SkybodySetup& setup,
                                            const SkybodyDeclare& declare);

/// The step functions of one number type for an instruction set; all sets give the same bits. Only
/// smooth plugins have functions on dual numbers.
const SkybodyKernels& kernels_for(const SkybodyPlugin& plugin, Isa isa,
                                  SkybodyNumber number = SKYBODY_NUMBER_REAL);

}  // namespace skybody
