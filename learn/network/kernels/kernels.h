// The kernels for an instruction set.
#pragma once

#include "core/base/simd/isa.h"
#include "learn/network/kernels/kernel_table.h"

namespace skybody::learn {

/// @param isa  an instruction set of the processor, such as best_isa()
const KernelTable& kernels_of(Isa isa);

}  // namespace skybody::learn
