// Derivatives of a plugin's functions: dual numbers against differences.
//
// A test names a plugin and a call. For random states and directions, one input block at a time, it
// compares the tangents with central differences of the functions on real numbers, and the values
// bit by bit with those of the functions on real numbers.
#pragma once

#include <bit>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {

/// Interleaves every row of doubles or state words with its row of tangents.
template <class T>
std::vector<T> with_tangents(const std::vector<T>& values, const std::vector<T>& tangents,
                             int lanes) {
  std::vector<T> rows;
  const auto width = static_cast<std::ptrdiff_t>(lanes);
  for (auto v = values.begin(), t = tangents.begin(); v != values.end(); v += width, t += width) {
    rows.insert(rows.end(), v, v + width);
    rows.insert(rows.end(), t, t + width);
  }
  return rows;
}

/// Extracts the values (part 0) or the tangents (part 1) of such rows.
template <class T>
std::vector<T> part_of(const std::vector<T>& rows, int part, int lanes) {
  std::vector<T> values;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (static_cast<int>(i) / lanes % 2 == part) values.push_back(rows[i]);
  }
  return values;
}

template <class Block>
constexpr bool kIsOfDoubles = std::is_same_v<typename Block::value_type, double>;

/// Makes a group of dual numbers from two groups of the same plugin.
inline Group with_tangents(const Group& values, const Group& tangents) {
  Group dual = tangents;
  Group::each(values, dual, [&](const auto& v, auto& t) {
    if constexpr (kIsOfDoubles<std::remove_cvref_t<decltype(v)>>) {
      t = with_tangents(v, t, values.lanes);
    }
  });
  dual.state = with_tangents(values.state, tangents.state, values.lanes);
  return dual;
}

inline Group part_of(const Group& dual, int part) {
  Group values = dual;
  Group::each(dual, values, [&](const auto& rows, auto& v) {
    if constexpr (kIsOfDoubles<std::remove_cvref_t<decltype(v)>>) {
      v = part_of(rows, part, dual.lanes);
    }
  });
  values.state = part_of(dual.state, part, dual.lanes);
  return values;
}

/// The same group with 0 for every double and word of state.
inline Group zeros(const Group& group) {
  Group zero = group;
  Group::each(group, zero, [](const auto&, auto& block) {
    if constexpr (kIsOfDoubles<std::remove_cvref_t<decltype(block)>>) {
      std::fill(block.begin(), block.end(), 0.0);
    }
  });
  std::fill(zero.state.begin(), zero.state.end(), 0u);
  return zero;
}

/// x + step * tangent. Entries without a tangent, such as a counter in the state, keep their bits.
inline Group moved(const Group& x, const Group& tangents, double step) {
  Group there = x;
  Group::each(tangents, there, [&](const auto& t, auto& v) {
    if constexpr (kIsOfDoubles<std::remove_cvref_t<decltype(v)>>) {
      for (std::size_t i = 0; i < v.size(); ++i) v[i] += step * t[i];
    }
  });
  for (std::size_t i = 0; i < x.state.size(); ++i) {
    const auto t = std::bit_cast<double>(tangents.state[i]);
    if (t == 0.0) continue;
    there.state[i] = std::bit_cast<std::uint64_t>(std::bit_cast<double>(x.state[i]) + step * t);
  }
  return there;
}

/// The output of a call, as rows of doubles, the state first.
inline std::vector<double> written(const Group& g, Instance::Call call) {
  std::vector<double> all;
  for (const std::uint64_t word : g.state) all.push_back(std::bit_cast<double>(word));
  for (const auto* block :
       {&g.buffer, &g.output, &g.observation, &g.reward, &g.robot_reward, &g.info}) {
    all.insert(all.end(), block->begin(), block->end());
  }
  if (call == Instance::Call::kProcess) {
    all.insert(all.end(), g.command.begin(), g.command.end());
  }
  for (const auto& block : g.held) all.insert(all.end(), block.begin(), block.end());
  return all;
}

/// A call of a plugin whose derivatives are compared.
struct Differentiated {
  std::string plugin;
  PluginWorld& world;
  Parameters given;
  Instance::Call call;
  std::set<int> counters;  ///< members of State that are not Real
};

class DerivativeCheck {
 public:
  explicit DerivativeCheck(const Differentiated& what)
      : what_(what), instance_(what.plugin, what.world, what.given) {}

  /// Compares on an instruction set. @returns the blocks that some output depends on
  std::set<std::string> run(int set) {
    std::mt19937_64 generator(5);
    std::set<std::string> used;
    compared_ = left_out_ = 0;
    for (int round = 0; round < kRounds; ++round) {
      const Group start = somewhere(generator, round);
      for (const auto& [name, block] : kBlocks) {
        Group tangents = zeros(start);
        point_anywhere(start.*block, tangents.*block, generator);
        if (compare(start, tangents, set)) used.insert(name);
      }
      Group tangents = zeros(start);
      point_anywhere_in_state(start, tangents, generator);
      if (compare(start, tangents, set)) used.insert("state");
      expect_lanes_left_alone(start, static_cast<std::uint32_t>(generator()), set);
      if (::testing::Test::HasFatalFailure()) break;
    }
    EXPECT_LT(20 * left_out_, compared_) << "too many points are not smooth";
    return used;
  }

 private:
  static constexpr int kLanes = SKYBODY_GROUP_LANES, kRounds = 12;
  static constexpr std::uint32_t kAll = 0xffffffffu;
  // Steps in units of a direction, which has the size of the inputs. The error of four-point
  // differences of a smooth function is about 1e-12 of the row's size by rounding (1e-16 / h), more
  // where the function subtracts large numbers, plus a term of order h^4.
  static constexpr double kStep = 1e-4, kTolerance = 2e-7;
  static constexpr std::pair<const char*, std::vector<double> Group::*> kBlocks[] = {
      {"bodies", &Group::bodies},
      {"bodies_before", &Group::before},
      {"q", &Group::q},
      {"u", &Group::u},
      {"params", &Group::params},
      {"rotor_speed", &Group::rotor_speed},
      {"rotor_command", &Group::rotor_command},
      {"action", &Group::action},
      {"command", &Group::command},
      {"buffer", &Group::buffer},
      {"input", &Group::input}};

  /// Random inputs after a reset and some calls, which bring the state to typical values of a
  /// flight.
  Group somewhere(std::mt19937_64& generator, int round) const {
    Group g = instance_.group(kLanes);
    for (int l = 0; l < kLanes; ++l) {
      g.key[static_cast<std::size_t>(kLanes + l)] = static_cast<std::uint64_t>(l);
      g.episode[static_cast<std::size_t>(l)] = 1 + static_cast<std::uint64_t>(round);
    }
    scatter(g, instance_.declared, generator);
    instance_.call(Instance::Call::kReset, g, kAll);
    for (int i = 0; i < 3; ++i) {
      scatter(g, instance_.declared, generator);
      for (int l = 0; l < kLanes; ++l) {
        g.step[static_cast<std::size_t>(l)] = generator() % 2;
        g.physics_step[static_cast<std::size_t>(l)] = generator() % 3000;
      }
      if (what_.call != Instance::Call::kReset) instance_.call(what_.call, g, kAll);
    }
    scatter(g, instance_.declared, generator);
    return g;
  }

  /// A tangent as large as the value, or 0.01 if the value is 0.
  static double tangent_of(double x, std::mt19937_64& generator) {
    const double unit = static_cast<double>(generator() >> 11) * 0x1p-52 - 1.0;
    return unit * (x == 0.0 ? 0.01 : std::abs(x));
  }
  static void point_anywhere(const std::vector<double>& x, std::vector<double>& tangents,
                             std::mt19937_64& generator) {
    for (std::size_t i = 0; i < x.size(); ++i) tangents[i] = tangent_of(x[i], generator);
  }
  void point_anywhere_in_state(const Group& x, Group& tangents, std::mt19937_64& generator) const {
    for (std::size_t i = 0; i < x.state.size(); ++i) {
      if (what_.counters.count(static_cast<int>(i) / kLanes) != 0) continue;
      const double t = tangent_of(std::bit_cast<double>(x.state[i]), generator);
      tangents.state[i] = std::bit_cast<std::uint64_t>(t);
    }
  }

  std::vector<double> outputs(Group g, int set) const {
    instance_.call(what_.call, g, kAll, set);
    return written(g, what_.call);
  }
  /// The largest magnitude in a row.
  static double size_of(const std::vector<double>& rows, std::size_t row) {
    double largest = 0.0;
    for (std::size_t l = 0; l < kLanes; ++l) {
      largest = std::max(largest, std::abs(rows[row * kLanes + l]));
    }
    return largest;
  }
  /// The outputs of a call on both sides of x.
  struct Sides {
    std::vector<double> there, back;
    double step;
    double slope(std::size_t i) const { return (there[i] - back[i]) / (2.0 * step); }
    /// Difference of the slopes on both sides.
    double bend(std::size_t i, double middle) const {
      return ((there[i] - middle) - (middle - back[i])) / step;
    }
  };
  Sides sides(const Group& x, const Group& tangents, double step, int set) const {
    return {outputs(moved(x, tangents, step), set), outputs(moved(x, tangents, -step), set), step};
  }

  /// @returns true if any output depends on the inputs that have tangents
  bool compare(const Group& x, const Group& tangents, int set) {
    Group plain = x;
    instance_.call(what_.call, plain, kAll, set);
    Group dual = with_tangents(x, tangents);
    instance_.call(what_.call, dual, kAll, set, SKYBODY_NUMBER_DUAL);
    EXPECT_TRUE(part_of(dual, 0).same_bits(plain)) << what_.plugin << ": values differ";

    const std::vector<double> values = written(plain, what_.call),
                              got = written(part_of(dual, 1), what_.call);
    const Sides near = sides(x, tangents, kStep, set), far = sides(x, tangents, 2.0 * kStep, set);
    bool depends = false;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::size_t row = i / kLanes;
      if (what_.counters.count(static_cast<int>(row)) != 0) continue;
      const double slope = near.slope(i), change = slope - far.slope(i);
      const double size = size_of(values, row) + std::abs(slope);
      ++compared_;
      // Detects a kink or a jump nearby. For a smooth function the bend doubles with the step, and
      // slopes agree. A change of the slope by s at a fraction p of the step has a `change` of s p
      // / 4, which vanishes if x is at the kink itself; the bends then give -s (1 - 3/2 p).
      const double bends = far.bend(i, values[i]) - 2.0 * near.bend(i, values[i]);
      if (!(std::abs(change) <= kTolerance * size && std::abs(bends) <= kTolerance * size)) {
        ++left_out_;
        continue;
      }
      const double want = slope + change / 3.0;
      depends = depends || std::abs(want) > 1e-3 * size;
      EXPECT_NEAR(got[i], want, kTolerance * size)
          << what_.plugin << ", row " << row << " of what it writes, lane " << i % kLanes
          << ", instruction set " << set;
    }
    return depends;
  }

  /// State, buffer and held inputs of inactive lanes keep values and tangents.
  void expect_lanes_left_alone(const Group& x, std::uint32_t mask, int set) const {
    std::mt19937_64 generator(mask);
    Group tangents = zeros(x);
    point_anywhere_in_state(x, tangents, generator);
    point_anywhere(x.buffer, tangents.buffer, generator);
    const Group before = with_tangents(x, tangents);
    Group after = before;
    instance_.call(what_.call, after, mask, set, SKYBODY_NUMBER_DUAL);
    for (int l = 0; l < kLanes; ++l) {
      if ((mask >> l & 1u) != 0) continue;
      const Group one = before.alone(l), same = after.alone(l);
      EXPECT_EQ(one.state, same.state) << what_.plugin << ", lane " << l;
      EXPECT_EQ(one.buffer, same.buffer) << what_.plugin << ", lane " << l;
      EXPECT_EQ(one.held, same.held) << what_.plugin << ", lane " << l;
      EXPECT_EQ(one.end, same.end) << what_.plugin << ", lane " << l;
    }
  }

  const Differentiated& what_;
  Instance instance_;
  int compared_ = 0, left_out_ = 0;
};

/// Compares a call's derivatives on every instruction set that the machine has.
/// @param inputs  the blocks that some output depends on; kept state depends on itself
inline void expect_derivatives(const Differentiated& what, const std::set<std::string>& inputs) {
  DerivativeCheck check(what);
  for (int set = 0; set < kIsaCount; ++set) {
    if (!machine_has(kIsas[set])) continue;
    EXPECT_EQ(check.run(set), inputs) << what.plugin;
  }
}

}  // namespace skybody::testing
