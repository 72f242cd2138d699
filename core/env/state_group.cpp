#include "core/env/state_group.h"

#include <algorithm>
#include <cstring>

#include "core/base/system/error.h"

namespace skybody {

StateGroup::StateGroup(const StateLayout& layout, int bodies, int lanes, int image_words,
                       std::unique_ptr<GroupStepper> stepper)
    : layout_(&layout),
      lanes_(lanes),
      words_(static_cast<std::size_t>(layout.words) * static_cast<std::size_t>(lanes)),
      bodies_(13 * static_cast<std::size_t>(bodies) * static_cast<std::size_t>(lanes)),
      memo_(static_cast<std::size_t>(layout.memo) * static_cast<std::size_t>(lanes)),
      images_(image_words, lanes),
      stepper_(std::move(stepper)) {
  blocks_.lanes = lanes;
  blocks_.bodies = bodies > 0 ? bodies_.data() : start_of(layout.q);
  for (const StateBlock& b : kStateBlocks) blocks_.*b.values = start_of(layout.*b.place);
  for (const InputBlock& b : kInputBlocks) blocks_.*b.values = reals(layout.*b.place);
  for (std::size_t i = 0; i < layout.held.size(); ++i) {
    if (layout.held[i].size > 0) blocks_.held[i] = reals(layout.held[i]);
  }
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
  double* values = writable(block, 1u << lane);
  if (lanes_ == 1) {
    std::memcpy(values, in, static_cast<std::size_t>(block.size) * 8);
    return;
  }
  for (int k = 0; k < block.size; ++k) values[k * lanes_ + lane] = in[k];
}

void StateGroup::clear(int lane) {
  for (int k = 0; k < words(); ++k) at(k)[lane] = 0;
  images_.clear(lane);
  undrawn_ &= ~(1u << lane);
  forget(1u << lane);
  occupied_ |= 1u << lane;
}

std::vector<std::uint64_t> StateGroup::save(int lane) const {
  std::vector<std::uint64_t> saved(static_cast<std::size_t>(words()));
  for (int k = 0; k < words(); ++k) saved[static_cast<std::size_t>(k)] = at(k)[lane];
  return saved;
}

void StateGroup::restore(int lane, const std::vector<std::uint64_t>& saved) {
  const auto count = static_cast<std::size_t>(words());
  SKYBODY_DEMAND(saved.size() == count, "a snapshot of another layout");
  for (std::size_t k = 0; k < count; ++k) at(static_cast<int>(k))[lane] = saved[k];
  images_.clear(lane);
  undrawn_ |= 1u << lane;
  forget(1u << lane);
}

std::vector<BodyState> StateGroup::body_states(int lane) const {
  SKYBODY_DEMAND((current_ >> lane & 1u) != 0, "bodies of a lane that is not refreshed");
  const std::size_t count = bodies_.size() / 13 / static_cast<std::size_t>(lanes_);
  std::vector<BodyState> out(std::max<std::size_t>(count, 1));
  auto* values = reinterpret_cast<double*>(out.data());
  for (std::size_t k = 0; k < 13 * out.size(); ++k) {
    values[k] =
        blocks_.bodies[k * static_cast<std::size_t>(lanes_) + static_cast<std::size_t>(lane)];
  }
  return out;
}

}  // namespace skybody
