// The hover environment of W quadrotors: what a step reads and writes, and the step.
#pragma once

#include <cstdint>

#include "bench/limit/free_flight.h"
#include "bench/limit/loop.h"
#include "bench/limit/rows.h"
#include "bench/limit/twin.h"

namespace skybody::bench::limit {

constexpr int kHoverObservation = 22, kHoverActions = 4;
constexpr double kHorizon = 20000.0;  ///< steps of an episode

/// Where the values of an environment lie in its block.
enum HoverValue {
  kPosition = 0,
  kRotation = 3,
  kVelocity = 7,
  kSpin = 10,
  kRotor = 13,
  kTarget = 17,
  kTargetYaw = 20,
  kStep = 21,  ///< of the episode
  kHoverValues = 22
};
template <int W>
using HoverBlock = Block<W, kHoverValues>;

/// Begins the next episode of one environment: start and target drawn as scenarios/hover.yaml has
/// them, rotors at hover speed. Never inlined: rare, and the same code for all widths.
/// @param values  its first value; the others lie `stride` doubles apart
void begin_episode(double* values, int stride, std::uint64_t environment, std::uint64_t episode);

/// What a step without engine does for the environments of one block.
/// @tparam Real  double, a pack, or two
template <class Real>
class HoverStep {
 public:
  static constexpr int W = Lanes<Real>::kCount;

  SKYBODY_INLINE explicit HoverStep(HoverBlock<W>& block) : block_(block) {}

  /// @param first    id of the first environment
  /// @param repeats  physics steps
  SKYBODY_INLINE void run(std::uint64_t first, const Rows& rows, int repeats) {
    load_state();
    Real command[4];
    take_actions(rows.action, command);
    for (int k = 0; k < repeats; ++k) fly(s_, command);
    step_ = get(kStep) + 1.0;
    if (any_ended(rows.ended)) [[unlikely]]
      begin_again(first, rows.ended);
    observe(rows);
    store_state();
    write_actions(rows.observation);
  }

 private:
  using L = Lanes<Real>;
  SKYBODY_INLINE Real get(int k) const { return L::load(block_.value[k]); }
  SKYBODY_INLINE void put(int k, const Real& x) { L::store(block_.value[k], x); }
  SKYBODY_INLINE Vec3<Real> get3(int k) const { return {get(k), get(k + 1), get(k + 2)}; }
  SKYBODY_INLINE void put3(int k, const Vec3<Real>& v) {
    put(k, v.x);
    put(k + 1, v.y);
    put(k + 2, v.z);
  }

  SKYBODY_INLINE void load_state() {
    s_.position = get3(kPosition);
    s_.rotation = {get(kRotation), get(kRotation + 1), get(kRotation + 2), get(kRotation + 3)};
    s_.velocity = get3(kVelocity);
    s_.spin = get3(kSpin);
    for (int i = 0; i < 4; ++i) s_.rotor[i] = get(kRotor + i);
  }
  SKYBODY_INLINE void store_state() {
    put3(kPosition, s_.position);
    put(kRotation, s_.rotation.w);
    put3(kRotation + 1, {s_.rotation.x, s_.rotation.y, s_.rotation.z});
    put3(kVelocity, s_.velocity);
    put3(kSpin, s_.spin);
    for (int i = 0; i < 4; ++i) put(kRotor + i, s_.rotor[i]);
    put(kStep, step_);
  }

  /// Clips, and scales to rotor speeds.
  SKYBODY_INLINE void take_actions(const float* rows, Real* command) {
    // Twice, as rows and as columns: no value waits for its own way through memory.
    for (int k = 0; k < 4 * W; ++k) {
      const float a = -1.0f > rows[k] ? -1.0f : rows[k];
      action_[k] = 1.0f < a ? 1.0f : a;
    }
    Real column[4];
    read_columns(rows, column);
    for (int i = 0; i < 4; ++i) {
      const Real clipped = smaller(larger(column[i], Real(-1.0)), Real(1.0));
      command[i] = smaller(clipped * 1150.0 + 1150.0, Real(kMaxRotorSpeed));
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

  /// As Gymnasium's next-step autoreset: the step that was just made does not count where an
  /// episode had ended.
  SKYBODY_INLINE void begin_again(std::uint64_t first, const std::uint8_t* ended) {
    store_state();
    for (int l = 0; l < W; ++l) {
      if (ended[l] == 0) continue;
      begin_episode(&block_.value[0][l], W, first + static_cast<unsigned>(l), block_.episode[l]++);
      for (int i = 0; i < 4; ++i) block_.action[l][i] = action_[4 * l + i] = -1.0f;
    }
    load_state();
    step_ = get(kStep);
  }

  /// Observation, reward and ends of where the vehicles are now.
  SKYBODY_INLINE void observe(const Rows& rows) {
    const Quat<Real>& q = s_.rotation;
    const Vec3<Real>& p = s_.position;
    const Vec3<Real> error = get3(kTarget) - p;
    const Real xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
    const Real sine = 2.0 * (q.x * q.y + q.w * q.z), cosine = 1.0 - 2.0 * (yy + zz);
    const auto left = cosine <= Real(0.0);
    Real yaw = atan2_right(sine, cosine);
    Real yaw_error = get(kTargetYaw) - yaw;
    if (bits(left) != 0) [[unlikely]] {  // the nose behind them: the full circle
      yaw = pick(left, full_atan2(sine, cosine), yaw);
      yaw_error = wrapped(get(kTargetYaw) - yaw);
    }
    const auto turned_round = q.w < Real(0.0);
    const auto upright = [&](const Real& x) { return pick(turned_round, -x, x); };

    const Real far = larger(larger(magnitude(p.x), magnitude(p.y)), magnitude(p.z));
    constexpr double kTiltCosine = 7.963267107332633e-4;  // cos 1.57
    // Positive where one of the three has failed.
    const Real failure =
        larger(larger(kTiltCosine - (1.0 - 2.0 * (xx + yy)), far - 7.0), magnitude(yaw) - 1.57);
    const Real ending = larger(failure, step_ - (kHorizon - 0.5));

    // 1 / (1 + 2.56 |e|^2) + 0.01 / (1 + |w|^2) with one division; nothing at a reset.
    const Real near = 1.0 + 2.56 * (squared_norm(error) + yaw_error * yaw_error);
    const Real calm = 1.0 + squared_norm(s_.spin);
    const Real reward = pick(step_ > Real(0.0), (calm + 0.01 * near) / (near * calm), Real(0.0));

    const Real values[14] = {error.x,       error.y,       error.z,       yaw_error,
                             s_.velocity.x, s_.velocity.y, s_.velocity.z, upright(q.w),
                             upright(q.x),  upright(q.y),  upright(q.z),  s_.spin.x,
                             s_.spin.y,     s_.spin.z};
    write_values(values, rows.observation, kHoverObservation);
    write_floats(reward, rows.reward);
    if (bits(ending > Real(0.0)) == 0) [[likely]] {
      std::memset(rows.ended, 0, W);
    } else {
      write_ends(bits(failure > Real(0.0)), bits(step_ >= Real(kHorizon)), rows.ended);
    }
  }

  static SKYBODY_INLINE void write_ends(std::uint32_t failed, std::uint32_t over,
                                        std::uint8_t* ended) {
    for (int l = 0; l < W; ++l) {
      ended[l] = static_cast<std::uint8_t>(((failed >> l) & 1u) | ((over >> l) & 1u) << 1);
    }
  }

  /// This action and the one before: the last eight values of a row.
  SKYBODY_INLINE void write_actions(float* row) {
    for (int l = 0; l < W; ++l, row += kHoverObservation) {
      std::memcpy(row + 14, action_ + 4 * l, 4 * sizeof(float));
      std::memcpy(row + 18, block_.action[l], 4 * sizeof(float));
    }
    std::memcpy(block_.action, action_, sizeof(action_));
  }

  HoverBlock<W>& block_;
  Flyer<Real> s_;
  Real step_;
  float action_[4 * W];  ///< clipped, a row of four for each environment
};

}  // namespace skybody::bench::limit
