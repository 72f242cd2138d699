#include "learn/ppo/minibatch_order.h"

#include <numeric>
#include <utility>

namespace skybody::learn {

void MinibatchOrder::shuffle(Random<double> random) {
  const std::size_t count = order_.size() / static_cast<std::size_t>(together_ ? steps_ : 1);
  std::iota(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(count), 0);
  std::uint64_t word = 0;
  for (std::size_t left = count, drawn = 0; left > 1; --left, ++drawn) {
    word = drawn % 2 == 0 ? random.bits() : word << 32;
    std::swap(order_[left - 1], order_[((word >> 32) * left) >> 32]);
  }
  // From the last one on, because the rows' places overlap those of later sequences.
  for (std::size_t s = count; together_ && steps_ > 1 && s-- > 0;) {
    const int sequence = order_[s];
    for (int step = 0; step < steps_; ++step) {
      order_[s * static_cast<std::size_t>(steps_) + static_cast<std::size_t>(step)] =
          step * rows_ + sequence;
    }
  }
}

}  // namespace skybody::learn
