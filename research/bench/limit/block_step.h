// A step of the environments of one block, for any task: actions in, physics, ends and
// resets, rows out. It is the complete work of a step without an engine.
#pragma once

#include <cstdint>

#include "research/bench/limit/loop.h"
#include "research/bench/limit/rows.h"
#include "research/bench/limit/vehicle.h"

namespace skybody::bench::limit {

/// Results of a task for the current states.
template <class Real>
struct Outcome {
  Real reward;
  Real failure;  ///< > 0 if the episode terminates
};

/// @tparam Task  of a Real (double, a pack, or two): State with the values of one environment in
///               memory order, fly(), observe() and begin_episode()
template <class Task>
class BlockStep {
 public:
  using Real = typename Task::Real;
  static constexpr int W = LaneLoads<Real>::kCount;
  /// Values of an environment: the state, the task's own values, steps of the episode.
  static constexpr int kStep = Task::kValues, kValues = kStep + 1;
  static constexpr int kObservation = Task::kObservation, kActions = 4;
  using Memory = Block<W, kValues>;

  SKYBODY_INLINE explicit BlockStep(Memory& block) : block_(block) {}

  /// @param first    id of the first environment
  /// @param repeats  physics steps
  SKYBODY_INLINE void run(std::uint64_t first, const Rows& rows, int repeats) {
    load_state();
    Real command[4];
    take_actions(rows.action, command);
    for (int k = 0; k < repeats; ++k) task_.fly(command);
    step_ = get(kStep) + 1.0;
    if (any_ended(rows.ended)) [[unlikely]]
      begin_again(first, rows.ended);
    observe(rows);
    store_state();
    write_actions(rows.observation);
  }

 private:
  using L = LaneLoads<Real>;
  SKYBODY_INLINE Real get(int k) const { return L::load(block_.value[k]); }
  SKYBODY_INLINE void put(int k, const Real& x) { L::store(block_.value[k], x); }

  SKYBODY_INLINE void load_state() {
    for (int k = 0; k < Task::kState; ++k) task_.value(k) = get(k);
  }
  SKYBODY_INLINE void store_state() {
    for (int k = 0; k < Task::kState; ++k) put(k, task_.value(k));
    put(kStep, step_);
  }

  /// Clips, and scales to rotor speeds.
  SKYBODY_INLINE void take_actions(const float* rows, Real* command) {
    // Stored twice, as rows and as columns, so that no load waits for a store of the same value.
    for (int k = 0; k < 4 * W; ++k) {
      const float a = -1.0f > rows[k] ? -1.0f : rows[k];
      action_[k] = 1.0f < a ? 1.0f : a;
    }
    Real column[4];
    read_columns(rows, column, kActions);
    for (int i = 0; i < 4; ++i) {
      const Real clipped = smaller(larger(column[i], Real(-1.0)), Real(1.0));
      command[i] = smaller(clipped * Task::kSpeedScale + Task::kSpeedScale, Real(kMaxRotorSpeed));
    }
  }

  static SKYBODY_INLINE bool any_ended(const std::uint8_t* ended) {
    if constexpr (W == 1) {
      return *ended != 0;
    } else if constexpr (W == 4) {
      std::uint32_t all;
      std::memcpy(&all, ended, sizeof(all));
      return all != 0;
    } else {
      std::uint64_t all[W / 8];
      std::memcpy(all, ended, sizeof(all));
      return (all[0] | all[W / 8 - 1]) != 0;
    }
  }

  /// As in Gymnasium's next-step autoreset: if an episode had ended, the step just made does not
  /// count.
  SKYBODY_INLINE void begin_again(std::uint64_t first, const std::uint8_t* ended) {
    store_state();
    for (int l = 0; l < W; ++l) {
      if (ended[l] == 0) continue;
      Task::begin_episode(&block_.value[0][l], W, first + static_cast<unsigned>(l),
                          block_.episode[l]++);
      for (int i = 0; i < 4; ++i) block_.action[l][i] = action_[4 * l + i] = -1.0f;
    }
    load_state();
    step_ = get(kStep);
  }

  SKYBODY_INLINE void observe(const Rows& rows) {
    constexpr int kOwn = Task::kOwnObservation;
    Real values[kOwn];
    const Outcome<Real> outcome = task_.observe(
        [&](int k) __attribute__((always_inline)) { return get(k); }, values);
    write_values(values, rows.observation, Task::kObservation);
    // The reward of a reset is 0.
    write_floats(pick(step_ > Real(0.0), outcome.reward, Real(0.0)), rows.reward);
    const Real over = step_ - (Task::kHorizon - 0.5);
    if (bits(larger(outcome.failure, over) > Real(0.0)) == 0) [[likely]] {
      std::memset(rows.ended, 0, W);
    } else {
      write_ends(bits(outcome.failure > Real(0.0)), bits(over > Real(0.0)), rows.ended);
    }
  }

  static SKYBODY_INLINE void write_ends(std::uint32_t failed, std::uint32_t over,
                                        std::uint8_t* ended) {
    for (int l = 0; l < W; ++l) {
      ended[l] = static_cast<std::uint8_t>(((failed >> l) & 1u) | ((over >> l) & 1u) << 1);
    }
  }

  /// The last values of a row: this action and, if the task shows it, the previous one.
  SKYBODY_INLINE void write_actions(float* row) {
    constexpr int kOwn = Task::kOwnObservation;
    for (int l = 0; l < W; ++l, row += Task::kObservation) {
      std::memcpy(row + kOwn, action_ + 4 * l, 4 * sizeof(float));
      if constexpr (Task::kObservation > kOwn + 4) {
        std::memcpy(row + kOwn + 4, block_.action[l], 4 * sizeof(float));
      }
    }
    if constexpr (Task::kObservation > kOwn + 4) {
      std::memcpy(block_.action, action_, sizeof(action_));
    }
  }

  Memory& block_;
  Task task_;
  Real step_;
  float action_[4 * W];  ///< clipped, a row of four for each environment
};

}  // namespace skybody::bench::limit
