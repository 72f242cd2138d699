// The kernels for an instruction set.
#pragma once

#include "core/base/isa.h"
#include "learn/network/kernels/kernel_table.h"

namespace skybody::learn {

/// @param isa  that the processor has, such as best_isa()
const KernelTable& kernels_of(Isa isa);

}  // namespace skybody::learn
