// The same networks on Eigen, for comparison: each instruction set compiled as a whole.
#pragma once

#include <vector>

namespace skybody::bench {

/// Times of the fastest of several passes over all rows [s].
struct NetworkTimes {
  double forward, both;  ///< both: with backward
};

/// Times a tanh network on Eigen's products, or with `bare` only its products.
/// @param sizes  from inputs to outputs
namespace v3 {
NetworkTimes time_eigen(const std::vector<int>& sizes, int rows, int repeats, bool bare);
}
namespace v4 {
NetworkTimes time_eigen(const std::vector<int>& sizes, int rows, int repeats, bool bare);
}

}  // namespace skybody::bench
