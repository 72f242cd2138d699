// Orthogonal matrices, which networks begin with.
#pragma once

#include <cstdint>
#include <vector>

namespace skybody::learn {

/// Where the numbers of a matrix come from: core/base/random.h with key (`key`, 0), episode 0,
/// stream `stream` and step `step`.
struct WeightSource {
  std::uint64_t key = 0, stream = 0, step = 0;
};

/// A matrix whose shorter side's rows or columns are orthonormal, drawn uniformly among these:
/// Gram and Schmidt's of one of standard normals (Saxe, McClelland and Ganguli, ICLR 2014).
/// @returns rows x columns, row by row
std::vector<double> orthogonal_matrix(int rows, int columns, const WeightSource& source);

}  // namespace skybody::learn
