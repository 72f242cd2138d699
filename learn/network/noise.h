// Standard normals for actions, many a call: a pure function of key and counter, as the numbers of
// core/base/random.h are, and from the same generator.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/isa.h"
#include "core/base/random.h"

namespace skybody::learn {

/// Which numbers: Philox's key and the parts of its counter that count calls.
struct NoiseCounter {
  RandomKey key;
  std::uint64_t episode = 0, stream = 0, step = 0;
};

/// Fills `values` with independent standard normals. Value i depends on the counter and on i alone,
/// not on how many are asked for. Magnitudes are at most 6.8: a normal lies beyond once in 10^11.
/// The bits are the same on v3 and v4.
void draw_normals(const NoiseCounter& counter, std::span<float> values, Isa isa);

}  // namespace skybody::learn
