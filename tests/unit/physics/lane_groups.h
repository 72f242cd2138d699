// The lanes of a group, stepped side by side in packs or each in a group of its own.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/simd/lane_mask.h"
#include "core/physics/step/group_stepper.h"
#include "core/physics/world/lane_values.h"
#include "tests/unit/physics/stepper.h"

namespace skybody::test {

inline constexpr std::uint32_t kAllLanes = ~0u >> (32 - kGroupLanes);
inline constexpr std::uint32_t kSomeLanes = 0x6bff4f6b;  // used in some steps

/// The values of a full group, and a stepper on them.
struct PackGroup {
  PackGroup(const World& w, const GroupPhysics& physics)
      : world(w),
        stepper(physics.make_stepper(kGroupLanes)),
        scratch(physics.make_scratch()),
        bodies(size(13 * static_cast<int>(w.bodies.size()))) {
    for (const LaneBlock& b : kLaneBlocks) values.emplace_back(size((w.layout.*b.place).size));
    for (const Block& b : w.layout.held) held.emplace_back(size(b.size));
    for (std::size_t i = 0; i < held.size(); ++i) {
      if (held[i].size() > 0) group.held[i] = held[i].data();
    }
    group.lanes = kGroupLanes;
    group.bodies = bodies.data();
    for (const StateBlock& b : kStateBlocks) group.*b.values = values_at(b.place).data();
    for (const InputBlock& b : kInputBlocks) group.*b.values = values_at(b.place).data();
  }
  static std::size_t size(int values) { return static_cast<std::size_t>(values * kGroupLanes); }

  void set(int lane, const LaneState& state) {
    for (std::size_t b = 0; b < values.size(); ++b)
      put(values[b], lane, state.*kLaneBlocks[b].values);
    for (std::size_t i = 0; i < held.size(); ++i) put(held[i], lane, state.held[i]);
  }
  static void put(AlignedArray<double>& block, int lane, const std::vector<double>& values) {
    for (std::size_t k = 0; k < values.size(); ++k) {
      block[k * kGroupLanes + static_cast<std::size_t>(lane)] = values[k];
    }
  }
  AlignedArray<double>& values_at(Block StateLayout::*place) {
    std::size_t b = 0;
    while (kLaneBlocks[b].place != place) ++b;
    return values[b];
  }
  void refresh(std::uint32_t lanes) { stepper->refresh(group, lanes, lanes, scratch); }
  std::uint32_t advance(std::uint32_t lanes) { return stepper->advance(group, lanes, scratch); }

  const World& world;
  std::unique_ptr<GroupStepper> stepper;
  PhysicsScratch scratch;
  AlignedArray<double> bodies;
  std::vector<AlignedArray<double>> values;  ///< in the order of kLaneBlocks
  std::vector<AlignedArray<double>> held;
  GroupBlocks group;
};

/// The same lanes, each in a group of its own.
struct Alone {
  explicit Alone(const World& world) : states(kGroupLanes) {
    for (int lane = 0; lane < kGroupLanes; ++lane) steppers.push_back(make_stepper(world));
  }
  void set(int lane, const LaneState& state) { states[static_cast<std::size_t>(lane)] = state; }
  void refresh(std::uint32_t lanes) {
    each_lane(lanes, [&](int l) {
      const auto lane = static_cast<std::size_t>(l);
      steppers[lane]->update_bodies(states[lane]);
    });
  }
  std::uint32_t advance(std::uint32_t lanes) {
    std::uint32_t through = 0;
    near = 0;
    each_lane(lanes, [&](int l) {
      const auto lane = static_cast<std::size_t>(l);
      if (steppers[lane]->advance(states[lane])) through |= 1u << l;
      if (steppers[lane]->was_near()) near |= 1u << l;
    });
    return through;
  }

  std::vector<LaneState> states;
  std::vector<std::unique_ptr<Stepper>> steppers;
  std::uint32_t near = 0;
};

}  // namespace skybody::test
