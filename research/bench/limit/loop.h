// Arguments of all limit loops, and the layout of their memory.
#pragma once

#include <cstddef>
#include <cstdint>

namespace skybody::bench::limit {

/// Rows of environments, contiguous.
struct Rows {
  const float* action = nullptr;  ///< [N, 4], any values but NaN
  float* observation = nullptr;   ///< [N, width]
  float* reward = nullptr;        ///< [N]
  std::uint8_t* ended = nullptr;  ///< [N]: 1 terminated, 2 horizon, 3 both; read before written
};

/// One round over some blocks of an array.
struct LoopCall {
  void* blocks;     ///< Block<W, V>, the array's first
  Rows rows;        ///< of environment 0
  int first, last;  ///< blocks first ... last - 1
  int repeats;      ///< physics steps of a step, K
};
using Loop = void (*)(const LoopCall& call);

/// State of W environments; values k of all of them are contiguous.
template <int W, int V>
struct alignas(64) Block {
  double value[V][W];
  float action[W][4];        ///< of the previous step
  std::uint64_t episode[W];  ///< number of the next episode
};

/// A compiled loop.
struct LoopKind {
  const char* name = "";  ///< "8 lanes, v4"
  int width = 1;          ///< number of lanes
  std::size_t block_bytes = 0;
  int observation = 0;  ///< floats per row
  int actions = 0;      ///< likewise
  Loop run = nullptr;
};

}  // namespace skybody::bench::limit
