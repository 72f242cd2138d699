// WorldState of one lane group: L environments side by side, every value a 64-bit word.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/model/layout.h"

namespace skybody {

/// Owns the words of L environments: word k of lane l is at k * L + l. A plain container; who may
/// touch it when is the caller's business (one worker at a time).
class StateGroup {
 public:
  /// @param words  words of one environment
  /// @param lanes  L >= 1; all words start as zero
  StateGroup(int words, int lanes);

  int lanes() const { return lanes_; }
  int words() const { return words_; }

  /// First value of a block of doubles; stride L.
  double* reals(Block block) { return reals(block.offset); }
  const double* reals(Block block) const { return reals(block.offset); }
  double* reals(int word) { return reinterpret_cast<double*>(at(word)); }
  const double* reals(int word) const { return reinterpret_cast<const double*>(at(word)); }

  /// First value of a block of std::uint64_t; stride L.
  std::uint64_t* bits(int word) { return reinterpret_cast<std::uint64_t*>(at(word)); }
  const std::uint64_t* bits(int word) const {
    return reinterpret_cast<const std::uint64_t*>(at(word));
  }

  /// Copies one lane's block of doubles out of, or into, the group.
  void gather(int lane, Block block, double* out) const;
  void scatter(int lane, Block block, const double* in);

  /// All words of one lane, in order.
  std::vector<std::uint64_t> save(int lane) const;
  void restore(int lane, const std::vector<std::uint64_t>& saved);

 private:
  struct Free {
    void operator()(std::byte* p) const { ::operator delete[](p, std::align_val_t{64}); }
  };
  std::byte* at(int word) const {
    return data_.get() + static_cast<std::size_t>(word) * static_cast<std::size_t>(lanes_) * 8;
  }
  int words_, lanes_;
  std::unique_ptr<std::byte[], Free> data_;
};

}  // namespace skybody
