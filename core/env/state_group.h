// State words of one lane group: L environments side by side, every value a 64-bit word; and data
// derived from them.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "core/env/image_memory.h"
#include "core/model/state_layout.h"
#include "core/physics/step/group_stepper.h"
#include "core/physics/world/lane_state.h"

namespace skybody {

/// Owns the words of L environments: word k of lane l is at k * L + l. Not synchronized: callers
/// must let one worker at a time use a group.
///
/// Bodies and stepper are derived from q, u, rotor speeds and constants. Writers get the memory
/// from writable(), which marks the derived data of their lanes as stale; refresh() recomputes it.
/// The stepper advances coordinates and bodies together.
class StateGroup {
 public:
  /// @param bodies   of the world; 0: they equal q and u (GroupPhysics::bodies_are_coordinates)
  /// @param lanes    L >= 1; all words start as zero
  /// @param image_words  of the sensors' images of each environment
  /// @param stepper  the physics of this group
  StateGroup(const StateLayout& layout, int bodies, int lanes, int image_words,
             std::unique_ptr<GroupStepper> stepper);

  const StateLayout& layout() const { return *layout_; }
  int lanes() const { return lanes_; }
  int words() const { return layout_->words; }
  /// Lanes that hold an environment: those on which clear() was called.
  std::uint32_t occupied() const { return occupied_; }

  // --- reading; stride L ------------------------------------------------------------------------

  /// First value of a block of doubles, or the double at any word.
  const double* reals(Block block) const { return reals(block.offset); }
  const double* reals(int word) const { return reinterpret_cast<const double*>(at(word)); }
  /// First value of words as raw bits.
  const std::uint64_t* bits(int word) const { return at(word); }
  const ImageMemory& images() const { return images_; }
  /// Copies one lane's block of doubles.
  void gather(int lane, Block block, double* out) const;
  /// All words of one lane, in order. Its images follow from them: see restore().
  std::vector<std::uint64_t> save(int lane) const;

  /// The lanes with parameters that no rigid body can have. Valid for lanes that are current
  /// (refresh()).
  std::uint32_t unphysical() const { return stepper_->unphysical(); }

  // --- writing; stride L ------------------------------------------------------------------------

  /// First value of a block of doubles, or of a part of one. @param lanes  that may be written
  double* writable(Block block, std::uint32_t lanes) {
    note_write(block, lanes);
    return start_of(block);
  }
  std::uint64_t* writable(HeaderWord word) { return at(word); }
  /// As writable(), but without marking: callers that change a lane's values must call writable()
  /// for it afterwards.
  double* unmarked(Block block) { return reinterpret_cast<double*>(at(block.offset)); }
  /// A plugin's words. @param k  place within the block plugin_state
  std::uint64_t* plugin_bits(int k) { return at(layout_->plugin_state.offset + k); }
  double* plugin_reals(int k) { return reinterpret_cast<double*>(plugin_bits(k)); }
  /// The lanes whose parameters have not been written since settle() was called for them.
  std::uint32_t settled() const { return settled_; }
  void settle(std::uint32_t lanes) { settled_ |= lanes; }
  void unsettle(std::uint32_t lanes) { settled_ &= ~lanes; }
  /// Memory of plugins beside the state (SkybodyDeclare::memo): never saved, restored or hashed.
  double* memo(int k) { return memo_.data() + static_cast<std::ptrdiff_t>(k) * lanes_; }

  /// Copies one lane's block of doubles into the group.
  void scatter(int lane, Block block, const double* in);
  /// Sets all words of a lane to zero; the lane is occupied from then on.
  void clear(int lane);
  ImageMemory& images() { return images_; }
  /// The lane's images are 0 until its sensors draw them again (CompiledScenario::update).
  /// @param saved  result of save()
  void restore(int lane, const std::vector<std::uint64_t>& saved);
  /// The lanes whose images are to be drawn again, of those in `lanes`; they count as drawn from
  /// then on.
  std::uint32_t take_undrawn(std::uint32_t lanes) {
    const std::uint32_t taken = undrawn_ & lanes;
    undrawn_ &= ~lanes;
    return taken;
  }

  // --- physics ----------------------------------------------------------------------------------

  /// Makes bodies and stepper current for these lanes.
  void refresh(std::uint32_t lanes, PhysicsScratch& scratch) {
    const std::uint32_t stale = lanes & ~current_;
    if (stale == 0) return;
    stepper_->refresh(blocks_, stale, stale & ~derived_, scratch);
    current_ |= stale;
    derived_ |= stale;
  }
  /// One physics step. @returns the lanes that succeeded, see GroupStepper::advance
  std::uint32_t advance(std::uint32_t lanes, PhysicsScratch& scratch) {
    refresh(lanes, scratch);
    return stepper_->advance(blocks_, lanes, scratch);
  }
  /// See GroupStepper.
  void accelerations(int lane, PhysicsScratch& scratch, double* udot) {
    refresh(1u << lane, scratch);
    stepper_->accelerations(blocks_, lane, scratch, udot);
  }
  /// @param out  memory of this group, as in GroupStepper
  void joint_reactions(std::uint32_t lanes, std::span<const int> bodies, PhysicsScratch& scratch,
                       double* out) {
    refresh(lanes, scratch);
    stepper_->joint_reactions(blocks_, lanes, bodies, scratch, out);
  }
  std::uint32_t may_touch(std::uint32_t lanes, PhysicsScratch& scratch) {
    refresh(lanes, scratch);
    return stepper_->may_touch(blocks_, lanes, scratch);
  }
  void add_contacts(int lane, PhysicsScratch& scratch, std::vector<Contact>& out) {
    refresh(1u << lane, scratch);
    stepper_->add_contacts(blocks_, lane, scratch, out);
  }
  const StepCounts& step_counts() const { return stepper_->counts(); }

  /// 13 per body (BodyState), stride L. Valid for lanes that are refreshed.
  const double* bodies() const { return blocks_.bodies; }
  /// Motion of all bodies of one lane, which must be refreshed.
  std::vector<BodyState> body_states(int lane) const;

 private:
  std::uint64_t* at(int word) {
    return words_.data() + static_cast<std::size_t>(word) * static_cast<std::size_t>(lanes_);
  }
  const std::uint64_t* at(int word) const {
    return words_.data() + static_cast<std::size_t>(word) * static_cast<std::size_t>(lanes_);
  }
  double* start_of(Block block) { return reinterpret_cast<double*>(at(block.offset)); }

  /// Marks the data that becomes stale when a block, or a part of one, is written.
  void note_write(Block block, std::uint32_t lanes) {
    const int begin = block.offset, end = block.offset + block.size;
    if (begin < layout_->rotor_command.offset) current_ &= ~lanes;  // q, u, rotor speeds
    const Block& params = layout_->params;
    if (begin >= params.offset + params.size || end <= params.offset) return;
    unsettle(lanes);
    if (begin < params.offset + layout_->physics_params) forget(lanes);
  }
  void forget(std::uint32_t lanes) {
    unsettle(lanes);
    current_ &= ~lanes;
    derived_ &= ~lanes;
  }

  const StateLayout* layout_;
  int lanes_;
  AlignedArray<std::uint64_t> words_;
  AlignedArray<double> bodies_, memo_;
  ImageMemory images_;
  GroupBlocks blocks_;
  std::unique_ptr<GroupStepper> stepper_;
  std::uint32_t current_ = 0;  ///< lanes whose bodies are up to date
  std::uint32_t derived_ = 0;  ///< lanes whose parameters the stepper has read
  std::uint32_t settled_ = 0;
  std::uint32_t occupied_ = 0;
  std::uint32_t undrawn_ = 0;  ///< lanes restored since their images were drawn
};

}  // namespace skybody
