// Standard normals for actions, in bulk: a pure function of key and counter, like the numbers of
// core/base/math/random.h, and from the same generator.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/math/random.h"
#include "core/base/simd/isa.h"

namespace skybody::learn {

/// Selects the numbers: Philox's key and the counter's parts that identify a call.
struct NoiseCounter {
  RandomKey key;
  std::uint64_t episode = 0, stream = 0, step = 0;
};

/// Fills `values` with independent standard normals. Value i depends only on the counter and on i,
/// not on the size. Magnitudes are at most 6.8, which a normal exceeds once in 10^11. The bits are
/// the same on v3 and v4.
void draw_normals(const NoiseCounter& counter, std::span<float> values, Isa isa);

}  // namespace skybody::learn
