// A group stepped both in packs and one environment at a time, and compared bit for bit.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "tests/unit/physics/lane_groups.h"

namespace skybody::test {

inline void expect_same_bits(const AlignedArray<double>& packs, int lane, const double* alone,
                             const std::string& what) {
  const std::size_t count = packs.size() / kGroupLanes;
  for (std::size_t k = 0; k < count; ++k) {
    const double& value = packs[k * kGroupLanes + static_cast<std::size_t>(lane)];
    ASSERT_EQ(std::memcmp(&value, alone + k, sizeof(double)), 0)
        << what << ", value " << k << " of lane " << lane << ": " << value << " in packs, "
        << alone[k] << " alone";
  }
}

/// Both ways of stepping one group.
struct TwoWays {
  explicit TwoWays(const World& world) : physics(world), packs(world, physics), alone(world) {}

  void set(int lane, const LaneState& state) {
    packs.set(lane, state);
    alone.set(lane, state);
  }
  void refresh(std::uint32_t lanes) {
    packs.refresh(lanes);
    alone.refresh(lanes);
  }
  /// @returns the lanes that did not fail; both ways must agree
  std::uint32_t advance(std::uint32_t lanes, const std::string& where) {
    const std::uint32_t through = packs.advance(lanes);
    EXPECT_EQ(through, alone.advance(lanes)) << where;
    EXPECT_EQ(packs.stepper->near(), alone.near) << where;
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      const LaneState& state = alone.states[static_cast<std::size_t>(lane)];
      for (std::size_t b = 0; b < packs.values.size(); ++b) {
        expect_same_bits(packs.values[b], lane, (state.*kLaneBlocks[b].values).data(),
                         where + ": block " + std::to_string(b));
      }
      expect_same_bits(packs.bodies, lane, reinterpret_cast<const double*>(state.bodies.data()),
                       where + ": bodies");
    }
    return through;
  }

  const GroupPhysics physics;
  PackGroup packs;
  Alone alone;
};

}  // namespace skybody::test
