// The same networks on Eigen, as a yardstick: each instruction set compiled as a whole.
#pragma once

#include <vector>

namespace skybody::bench {

/// Of the quickest of some passes over all rows [s].
struct NetworkTimes {
  double forward, both;  ///< both: with backward
};

/// Times a tanh network on Eigen's products, or with `bare` its products alone.
/// @param sizes  from inputs to outputs
namespace v3 {
NetworkTimes time_eigen(const std::vector<int>& sizes, int rows, int repeats, bool bare);
}
namespace v4 {
NetworkTimes time_eigen(const std::vector<int>& sizes, int rows, int repeats, bool bare);
}

}  // namespace skybody::bench
