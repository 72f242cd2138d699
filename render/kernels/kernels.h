// The kernels for an instruction set.
#pragma once

#include "core/base/simd/isa.h"
#include "render/kernels/kernel_table.h"

namespace skybody::render {

/// @param isa  an instruction set of the processor, such as best_isa()
const KernelTable& kernels_of(Isa isa);

}  // namespace skybody::render
