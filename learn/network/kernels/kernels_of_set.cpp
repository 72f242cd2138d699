// The kernels of one instruction set; compiled once per set (CMakeLists.txt).
#include "learn/network/kernels/gru.h"
#include "learn/network/kernels/images.h"
#include "learn/network/kernels/loops.h"
#include "learn/network/kernels/multiply.h"
#include "learn/network/kernels/normals.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

const KernelTable kTable = {
    .multiply = multiply,
    .outer = outer,
    .slope = slope,
    .scatter = scatter,
    .pixels = pixels,
    .gru = gru,
    .gru_slope = gru_slope,
    .adam = adam,
    .square_sum = square_sum,
    .add = add,
    .tanh = map_tanh,
    .normals = normals,
};

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
