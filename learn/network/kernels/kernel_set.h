// The head of every file of kernels. SKYBODY_KERNEL_SET is the name of the instruction set
// that the file is compiled for (CMakeLists.txt), and the namespace of all that is in it: the
// linker must not take one set's copy of an inline function for another's.
#pragma once

#include "learn/network/kernels/kernel_table.h"

#define SKYBODY_KERNEL inline __attribute__((always_inline))
