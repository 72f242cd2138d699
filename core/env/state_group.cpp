#include "core/env/state_group.h"

#include <cstring>
#include <new>

#include "core/base/error.h"

namespace skybody {

StateGroup::StateGroup(int words, int lanes) : words_(words), lanes_(lanes) {
  const std::size_t bytes = static_cast<std::size_t>(words) * static_cast<std::size_t>(lanes) * 8;
  data_.reset(static_cast<std::byte*>(::operator new[](bytes, std::align_val_t{64})));
  std::memset(data_.get(), 0, bytes);
}

void StateGroup::gather(int lane, Block block, double* out) const {
  if (block.size == 0) return;
  const double* values = reals(block);
  if (lanes_ == 1) {
    std::memcpy(out, values, static_cast<std::size_t>(block.size) * 8);
    return;
  }
  for (int k = 0; k < block.size; ++k) out[k] = values[k * lanes_ + lane];
}

void StateGroup::scatter(int lane, Block block, const double* in) {
  if (block.size == 0) return;
  double* values = reals(block);
  if (lanes_ == 1) {
    std::memcpy(values, in, static_cast<std::size_t>(block.size) * 8);
    return;
  }
  for (int k = 0; k < block.size; ++k) values[k * lanes_ + lane] = in[k];
}

std::vector<std::uint64_t> StateGroup::save(int lane) const {
  std::vector<std::uint64_t> saved(static_cast<std::size_t>(words_));
  for (int k = 0; k < words_; ++k) {
    std::memcpy(&saved[static_cast<std::size_t>(k)], at(k) + 8 * lane, 8);
  }
  return saved;
}

void StateGroup::restore(int lane, const std::vector<std::uint64_t>& saved) {
  SKYBODY_DEMAND(static_cast<int>(saved.size()) == words_, "a snapshot of another layout");
  for (int k = 0; k < words_; ++k) {
    std::memcpy(at(k) + 8 * lane, &saved[static_cast<std::size_t>(k)], 8);
  }
}

}  // namespace skybody
