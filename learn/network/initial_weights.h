// Orthogonal matrices, the initial weights of networks.
#pragma once

#include <cstdint>
#include <vector>

namespace skybody::learn {

/// Random stream of a matrix: core/base/math/random.h with key (`key`, 0), episode 0, stream
/// `stream` and step `step`.
struct WeightSource {
  std::uint64_t key = 0, stream = 0, step = 0;
};

/// A uniformly distributed matrix whose rows or columns, whichever are fewer, are orthonormal:
/// Gram-Schmidt on a matrix of standard normals (Saxe, McClelland and Ganguli, ICLR 2014).
/// @returns rows x columns, row by row
std::vector<double> orthogonal_matrix(int rows, int columns, const WeightSource& source);

}  // namespace skybody::learn
