// What every limit loop is called with, and how its memory is laid out.
#pragma once

#include <cstddef>
#include <cstdint>

namespace skybody::bench::limit {

/// Rows of environments, one after another without gaps.
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

/// State of W environments; value k of all of them lies side by side.
template <int W, int V>
struct alignas(64) Block {
  double value[V][W];
  float action[W][4];        ///< of the step before
  std::uint64_t episode[W];  ///< that begins next
};

/// A compiled loop.
struct LoopKind {
  const char* name = "";  ///< "8 lanes, v4"
  int width = 1;          ///< environments side by side
  std::size_t block_bytes = 0;
  int observation = 0;  ///< floats a row
  int actions = 0;      ///< likewise
  Loop run = nullptr;
};

}  // namespace skybody::bench::limit
