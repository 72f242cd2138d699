// Included first by every file of kernels. SKYBODY_KERNEL_SET is the instruction set that the file
// is compiled for (CMakeLists.txt), and the namespace of its content: the linker must not replace
// one set's copy of an inline function by another's.
#pragma once

#include "learn/network/kernels/kernel_table.h"

#define SKYBODY_KERNEL inline __attribute__((always_inline))
