// WorldState of one lane group: L environments side by side, every value a 64-bit word; and what
// follows from it.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/model/layout.h"
#include "core/physics/group_stepper.h"

namespace skybody {

/// Owns the words of L environments: word k of lane l is at k * L + l. A plain container; who may
/// touch it when is the caller's business (one worker at a time).
class StateGroup {
 public:
  /// @param bodies   of the world; 0: they are q and u (GroupPhysics::bodies_are_coordinates)
  /// @param lanes    L >= 1; all words start as zero
  /// @param stepper  the physics of this group
  StateGroup(const Layout& layout, int bodies, int lanes, std::unique_ptr<GroupStepper> stepper);

  int lanes() const { return lanes_; }
  int words() const { return layout_->words; }

  /// First value of a block of doubles; stride L.
  double* reals(Block block) { return reals(block.offset); }
  const double* reals(Block block) const { return reals(block.offset); }
  double* reals(int word) { return reinterpret_cast<double*>(at(word)); }
  const double* reals(int word) const { return reinterpret_cast<const double*>(at(word)); }

  /// First value of a block of std::uint64_t; stride L.
  std::uint64_t* bits(int word) { return at(word); }
  const std::uint64_t* bits(int word) const { return at(word); }

  /// Copies one lane's block of doubles out of, or into, the group; the latter is a change.
  void gather(int lane, Block block, double* out) const;
  void scatter(int lane, Block block, const double* in);

  /// All words of one lane, in order.
  std::vector<std::uint64_t> save(int lane) const;
  void restore(int lane, const std::vector<std::uint64_t>& saved);

  // --- what follows from the words: no information of its own -----------------------------------

  // Everybody but the stepper who writes through reals() must say so.

  /// q, u or rotor speeds of these lanes were written.
  void moved(std::uint32_t lanes) { current_ &= ~lanes; }
  /// Parameters were, or any of all these.
  void changed(std::uint32_t lanes) {
    current_ &= ~lanes;
    derived_ &= ~lanes;
  }
  /// Makes bodies and stepper current for these lanes.
  void refresh(std::uint32_t lanes, PhysicsScratch& scratch) {
    const std::uint32_t stale = lanes & ~current_;
    if (stale == 0) return;
    stepper_->refresh(blocks(), stale, stale & ~derived_, scratch);
    current_ |= stale;
    derived_ |= stale;
  }
  /// Lanes that hold an environment: those that were initialized.
  std::uint32_t occupied() const { return occupied_; }
  void occupy(std::uint32_t lanes) { occupied_ |= lanes; }

  GroupStepper& stepper() { return *stepper_; }
  const GroupStepper& stepper() const { return *stepper_; }
  const GroupBlocks& blocks() const { return blocks_; }
  /// 13 per body (BodyState), stride L.
  double* bodies() { return blocks_.bodies; }
  /// Motion of all bodies of one lane.
  std::vector<BodyState> body_states(int lane) const;

 private:
  std::uint64_t* at(int word) {
    return words_.data() + static_cast<std::size_t>(word) * static_cast<std::size_t>(lanes_);
  }
  const std::uint64_t* at(int word) const {
    return words_.data() + static_cast<std::size_t>(word) * static_cast<std::size_t>(lanes_);
  }
  const Layout* layout_;
  int lanes_;
  AlignedArray<std::uint64_t> words_;
  AlignedArray<double> bodies_;
  GroupBlocks blocks_;
  std::unique_ptr<GroupStepper> stepper_;
  std::uint32_t current_ = 0;  ///< lanes whose bodies are right
  std::uint32_t derived_ = 0;  ///< lanes whose parameters the stepper knows
  std::uint32_t occupied_ = 0;
};

}  // namespace skybody
