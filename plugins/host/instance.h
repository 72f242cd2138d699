// Making instances of plugins, and choosing their functions.
#pragma once

#include <memory>

#include "core/base/isa.h"
#include "plugins/api/abi.h"
#include "plugins/host/load_error.h"
#include "plugins/host/registry.h"

namespace skybody {

/// Makes and configures an instance of a plugin that can be used (entry.failure is empty). The
/// instance keeps its library loaded. The thread's floating-point mode is Skybody's meanwhile and
/// the caller's afterwards.
/// @throws PluginConfigureError with the plugin's own text if it refuses
/// @throws PluginLoadError      if the entry cannot be used
std::shared_ptr<const void> create_instance(const PluginEntry& entry, const SkybodySetup& setup,
                                            const SkybodyDeclare& declare);

/// The step functions of one type of number for an instruction set; all give the same bits. On dual
/// numbers only smooth plugins have any.
const SkybodyKernels& kernels_for(const SkybodyPlugin& plugin, Isa isa,
                                  SkybodyNumber number = SKYBODY_NUMBER_REAL);

}  // namespace skybody
