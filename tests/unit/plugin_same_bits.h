// The bits of a plugin's kernels in every instruction set, on random values.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "tests/unit/plugin_instance.h"

namespace skybody::testing {

/// Random but plausible motion, counters, actions and inputs (up to half beyond the declared
/// range).
inline void scatter(Group& g, const PluginInstance& declared, std::mt19937_64& generator) {
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(generator() >> 11) * 0x1p-53;
  };
  for (auto* block : {&g.bodies, &g.before}) {
    for (double& x : *block) x = uniform(-1.0, 1.0);
    for (int b = 0; 13 * b * g.lanes < static_cast<int>(block->size()); ++b) {
      for (int l = 0; l < g.lanes; ++l) {
        double sum = 0.0;
        for (int k = 3; k < 7; ++k)
          sum += g.at(*block, 13 * b + k, l) * g.at(*block, 13 * b + k, l);
        for (int k = 3; k < 7; ++k) g.at(*block, 13 * b + k, l) /= std::sqrt(sum);
        for (int k = 7; k < 13; ++k) g.at(*block, 13 * b + k, l) *= 8.0;
      }
    }
  }
  for (double& x : g.rotor_speed) x = uniform(0.0, 2200.0);
  for (double& x : g.rotor_command) x = uniform(0.0, 2200.0);
  for (double& x : g.action) x = uniform(-1.0, 1.0);
  for (auto* block : {&g.contacts, &g.contact_pairs, &g.joint_reactions, &g.sensors, &g.offered}) {
    for (double& x : *block) x = uniform(-1.0, 1.0);
  }
  for (int k = 0; k < static_cast<int>(declared.controller.low.size()); ++k) {
    const double low = declared.controller.low[static_cast<std::size_t>(k)],
                 high = declared.controller.high[static_cast<std::size_t>(k)];
    for (int l = 0; l < g.lanes; ++l)
      g.at(g.input, k, l) = uniform(1.5 * low - 0.5 * high, 1.5 * high - 0.5 * low);
  }
}

/// Tests that every instruction set gives the bits of double, lane by lane, and leaves inactive
/// lanes unchanged: 40 rounds of a full group with random masks.
inline void expect_same_bits(const std::string& plugin, PluginWorld& world,
                             const Parameters& given = {}) {
  constexpr int kLanes = SKYBODY_GROUP_LANES;
  const Instance instance(plugin, world, given);
  EXPECT_EQ(instance.plugin().vectorized, 1u) << plugin << " is written for double only";
  for (int set = 0; set < kIsaCount; ++set) {
    if (!machine_has(kIsas[set])) continue;
    std::mt19937_64 generator(11);
    Group g = instance.group(kLanes);
    for (int l = 0; l < kLanes; ++l)
      g.key[static_cast<std::size_t>(kLanes + l)] = static_cast<std::uint64_t>(l);
    for (int round = 0; round < 40; ++round) {
      scatter(g, instance.declared, generator);
      const auto mask = static_cast<std::uint32_t>(generator());
      const bool fresh = round % 10 == 0;
      for (int l = 0; l < kLanes; ++l) {
        if (fresh)
          g.physics_step[static_cast<std::size_t>(l)] = g.step[static_cast<std::size_t>(l)] = 0;
      }
      const Group before = g;
      if (fresh) instance.call(Instance::Call::kReset, g, mask, set);
      instance.call(instance.main_call(), g, mask, set);
      for (int l = 0; l < kLanes; ++l) {
        Group one = before.alone(l);
        if (((mask >> l) & 1u) != 0) {
          if (fresh) instance.call(Instance::Call::kReset, one);
          instance.call(instance.main_call(), one);
        } else {
          one.take_scratch(g.alone(l), instance.main_call() == Instance::Call::kControl);
        }
        ASSERT_TRUE(one.same_bits(g.alone(l)))
            << plugin << ", instruction set " << set << ", round " << round << ", lane " << l
            << (((mask >> l) & 1u) != 0 ? "" : " (not to be served)");
        ++g.physics_step[static_cast<std::size_t>(l)];
        ++g.step[static_cast<std::size_t>(l)];
        if (fresh) ++g.episode[static_cast<std::size_t>(l)];
      }
    }
  }
}

}  // namespace skybody::testing
