// The hover environment of W quadrotors: what a step reads and writes, and the step.
#pragma once

#include <cstdint>

#include "bench/limit/free_flight.h"
#include "bench/limit/loop.h"
#include "bench/limit/rows.h"

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

/// What a step without engine does for W environments.
template <int W>
class HoverStep {
 public:
  using Real = std::conditional_t<W == 1, double, Pack<W == 1 ? 2 : W>>;

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
  }

 private:
  SKYBODY_INLINE Real get(int k) const { return load_lanes<Real>(block_.value[k]); }
  SKYBODY_INLINE void put(int k, const Real& x) { store_lanes(block_.value[k], x); }
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
    if constexpr (W == 1) {
      for (int i = 0; i < 4; ++i) {
        const float a = rows[i] < -1.0f ? -1.0f : rows[i];
        action_[i] = a > 1.0f ? 1.0f : a;
        command[i] = smaller(action_[i] * 1150.0 + 1150.0, kMaxRotorSpeed);
      }
    } else {
      read_columns(rows, action_);
      for (int i = 0; i < 4; ++i) {
        const Floats<W> low = Floats<W>{} - 1.0f, high = Floats<W>{} + 1.0f;
        action_[i] = action_[i] < low ? low : action_[i];
        action_[i] = action_[i] > high ? high : action_[i];
        const Real a = to_pack<W>(action_[i]);
        command[i] = smaller(a * 1150.0 + 1150.0, Real(kMaxRotorSpeed));
      }
    }
  }

  static SKYBODY_INLINE bool any_ended(const std::uint8_t* ended) {
    if constexpr (W == 1) {
      return *ended != 0;
    } else {
      std::conditional_t<W == 8, std::uint64_t, std::uint32_t> all;
      std::memcpy(&all, ended, sizeof(all));
      return all != 0;
    }
  }

  /// As Gymnasium's next-step autoreset: the step that was just made does not count where an
  /// episode had ended.
  SKYBODY_INLINE void begin_again(std::uint64_t first, const std::uint8_t* ended) {
    store_state();
    for (int l = 0; l < W; ++l) {
      if (ended[l] == 0) continue;
      begin_episode(&block_.value[0][l], W, first + static_cast<unsigned>(l), block_.episode[l]++);
      for (int i = 0; i < 4; ++i) {
        block_.action[i][l] = -1.0f;
        if constexpr (W == 1) {
          action_[i] = -1.0f;
        } else {
          action_[i][l] = -1.0f;
        }
      }
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
    const auto left = cosine <= 0.0;
    Real yaw = atan2_right(sine, cosine);
    Real yaw_error = get(kTargetYaw) - yaw;
    if (any(left)) [[unlikely]] {  // lanes with the nose behind them: the full circle
      yaw = pick(left, atan2(sine, cosine), yaw);
      yaw_error = wrap_angle(get(kTargetYaw) - yaw);
    }
    const auto turned_round = q.w < 0.0;
    const auto upright = [&](const Real& x) { return pick(turned_round, -x, x); };

    const Real far = larger(larger(abs(p.x), abs(p.y)), abs(p.z));
    constexpr double kTiltCosine = 7.963267107332633e-4;  // cos 1.57
    const auto failed =
        logical_or(logical_or(1.0 - 2.0 * (xx + yy) < kTiltCosine, abs(yaw) > 1.57), far > 7.0);
    const auto over = step_ >= kHorizon;

    // b / (1 + 2.56 |e|^2) + 0.01 / (1 + |w|^2) with one division; nothing at a reset.
    const Real near = 1.0 + 2.56 * (squared_norm(error) + yaw_error * yaw_error);
    const Real calm = 1.0 + squared_norm(s_.spin);
    const Real reward = pick(step_ > 0.0, (calm + 0.01 * near) / (near * calm), Real(0.0));

    const Real values[14] = {error.x,       error.y,       error.z,       yaw_error,
                             s_.velocity.x, s_.velocity.y, s_.velocity.z, upright(q.w),
                             upright(q.x),  upright(q.y),  upright(q.z),  s_.spin.x,
                             s_.spin.y,     s_.spin.z};
    write(values, reward, failed, over, rows);
  }

  SKYBODY_INLINE void write(const Real (&values)[14], const Real& reward,
                            const MaskOf<Real>& failed, const MaskOf<Real>& over,
                            const Rows& rows) {
    float* row = rows.observation;
    if constexpr (W == 1) {
      for (int k = 0; k < 14; ++k) row[k] = static_cast<float>(values[k]);
      for (int i = 0; i < 4; ++i) {
        row[14 + i] = action_[i];
        row[18 + i] = block_.action[i][0];
        block_.action[i][0] = action_[i];
      }
      *rows.reward = static_cast<float>(reward);
      *rows.ended = static_cast<std::uint8_t>((failed ? 1 : 0) | (over ? 2 : 0));
    } else {
      Floats<W> v[4], rewards;
      for (int k = 0; k < 12; k += 4) {
        for (int i = 0; i < 4; ++i) to_floats(values[k + i], v[i]);
        write_columns(v, row + k, kHoverObservation);
      }
      to_floats(values[12], v[0]);
      to_floats(values[13], v[1]);
      v[2] = action_[0];
      v[3] = action_[1];
      write_columns(v, row + 12, kHoverObservation);
      Floats<W> now[4];
      for (int i = 0; i < 4; ++i) now[i] = action_[i];
      write_columns(now, row + 14, kHoverObservation);
      std::memcpy(v, block_.action, sizeof(v));
      std::memcpy(block_.action, action_, sizeof(action_));
      write_columns(v, row + 18, kHoverObservation);
      to_floats(reward, rewards);
      std::memcpy(rows.reward, &rewards, sizeof(rewards));
      write_ends(bits_from_mask(failed), bits_from_mask(over), rows.ended);
    }
  }

  static SKYBODY_INLINE void write_ends(std::uint32_t failed, std::uint32_t over,
                                        std::uint8_t* ended) {
    if ((failed | over) == 0) [[likely]] {
      std::memset(ended, 0, W);
      return;
    }
    for (int l = 0; l < W; ++l) {
      ended[l] = static_cast<std::uint8_t>(((failed >> l) & 1u) | ((over >> l) & 1u) << 1);
    }
  }

  HoverBlock<W>& block_;
  Flyer<Real> s_;
  Real step_;
  std::conditional_t<W == 1, float, Floats<W == 1 ? 4 : W>> action_[4];
};

}  // namespace skybody::bench::limit
