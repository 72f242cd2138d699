// Counter-based random numbers: each number is a pure function of (seed, env stream, episode,
// stream, step, draw), independent of the order of other draws. Philox4x64-10 (Salmon et al.,
// SC 2011) by Random123; distributions are our own, on core/base/math/math.h, with the same bits
// everywhere.
#pragma once

#include <Random123/philox.h>

#include <cstdint>

#include "core/base/math/math.h"
#include "core/base/math/quat.h"
#include "core/base/math/vec3.h"

namespace skybody {

/// Philox's key. Part of an environment's state; initially the user's seed and the env id.
struct RandomKey {
  std::uint64_t seed = 0;
  std::uint64_t stream_env = 0;
};

/// A stable stream id from a name (`sensors.imu`): 64-bit FNV-1a (Fowler, Noll, Vo).
constexpr std::uint64_t derive_stream(const char* name, std::size_t length) {
  std::uint64_t hash = 0xcbf29ce484222325ull;
  for (std::size_t i = 0; i < length; ++i) {
    hash = (hash ^ static_cast<unsigned char>(name[i])) * 0x100000001b3ull;
  }
  return hash;
}
constexpr std::uint64_t derive_stream(const char* name) {
  std::size_t length = 0;
  while (name[length] != '\0') ++length;
  return derive_stream(name, length);
}

/// Draws of one stream in one step of one environment per lane. All lanes draw equally often: draw
/// for all lanes and `select` afterwards.
template <class Real>
class Random {
 public:
  /// @param seed,stream_env  the lanes' keys   @param episode,step  the lanes' counters
  /// @param stream           id of the stream (derive_stream), the same in all lanes
  /// @param served           bits of the lanes that need numbers: Philox runs lane by lane
  SKYBODY_INLINE Random(const Word<Real>& seed, const Word<Real>& stream_env,
                        const Word<Real>& episode, const Word<Real>& step, std::uint64_t stream,
                        std::uint32_t served = ~0u)
      : seed_(seed),
        stream_env_(stream_env),
        episode_(episode),
        step_(step),
        stream_(stream),
        served_(served) {}

  /// The same key, episode and step in every lane.
  SKYBODY_INLINE Random(const RandomKey& key, std::uint64_t episode, std::uint64_t step,
                        std::uint64_t stream)
      : Random(Word<Real>(key.seed), Word<Real>(key.stream_env), Word<Real>(episode),
               Word<Real>(step), stream) {}

  /// 64 random bits. Four draws share one Philox block.
  SKYBODY_INLINE Word<Real> bits() {
    const unsigned place = static_cast<unsigned>(draw_ & 3);
    if (place == 0) fill(draw_ >> 2);
    ++draw_;
    return block_[place];
  }

  /// Uniform in [0, 1): the multiples of 2^-53.
  SKYBODY_INLINE Real uniform() {
    const Word<Real> word = bits() >> 11;
    const Real high = to_real(word >> 27), low = to_real(word & 0x7ffffffu);
    return (high * 134217728.0 + low) * 1.1102230246251565404e-16;
  }

  /// Uniform in [low, high]: low + (high - low) uniform(); rounding may reach `high`.
  SKYBODY_INLINE Real uniform(const Real& low, const Real& high) {
    return low + (high - low) * uniform();
  }

  /// Standard normal; uses exactly two uniforms and stores nothing (Box and Muller 1958, the cosine
  /// branch). Its magnitude is at most 8.58.
  SKYBODY_INLINE Real normal() {
    const Real radius = sqrt(-2.0 * log(1.0 - uniform()));
    return radius * cos(kTwoPi * uniform());
  }
  /// Two independent standard normals from one draw, for noise that is drawn often: both branches
  /// of Box and Muller, the cosine first. The radius uses the upper 32 bits, the angle the lower
  /// ones. The magnitude is at most 6.77; a normal variable exceeds it once in 8e10.
  SKYBODY_INLINE void normal_pair(Real& first, Real& second) {
    const Word<Real> word = bits();
    const Real radius = sqrt(-2.0 * log((to_real(word >> 32) + 0.5) * 0x1p-32));
    const Real turn = (kTwoPi * 0x1p-32) * to_real(word & 0xffffffffu);
    const SinCos<Real> angle = sincos(turn);
    first = radius * angle.cos;
    second = radius * angle.sin;
  }
  SKYBODY_INLINE Real normal(const Real& mean, const Real& deviation) {
    return mean + deviation * normal();
  }

  /// Uniform in 0..n-1, n >= 1: the upper half of bits * n. One draw; bias below n / 2^64.
  SKYBODY_INLINE Word<Real> integer(std::uint64_t n) {
    __extension__ typedef unsigned __int128 Wide;
    Word<Real> word = bits();
    for (int i = 0; i < kLanesOf<Real>; ++i) {
      set_lane(word, i, static_cast<std::uint64_t>((static_cast<Wide>(lane(word, i)) * n) >> 64));
    }
    return word;
  }

  /// Uniform on the unit sphere; uses two uniforms (Archimedes: z is uniform).
  SKYBODY_INLINE Vec3<Real> unit_vector() {
    const Real z = 2.0 * uniform() - 1.0;
    const SinCos<Real> angle = sincos(kTwoPi * uniform());
    const Real radius = sqrt((1.0 - z) * (1.0 + z));
    return {radius * angle.cos, radius * angle.sin, z};
  }

  /// A uniformly distributed rotation; uses three uniforms (Shoemake, Graphics Gems III, 1992).
  SKYBODY_INLINE Quat<Real> quaternion() {
    const Real u = uniform();
    const Real outer = sqrt(1.0 - u), inner = sqrt(u);
    const SinCos<Real> first = sincos(kTwoPi * uniform());
    const SinCos<Real> second = sincos(kTwoPi * uniform());
    return {inner * second.cos, outer * first.sin, outer * first.cos, inner * second.sin};
  }

 private:
  SKYBODY_INLINE void fill(std::uint64_t block) {
    for (int i = 0; i < kLanesOf<Real>; ++i) {
      if ((served_ >> i & 1u) == 0) continue;
      const r123::Philox4x64::ctr_type counter = {
          {lane(episode_, i), stream_, lane(step_, i), block}};
      const r123::Philox4x64::key_type key = {{lane(seed_, i), lane(stream_env_, i)}};
      const r123::Philox4x64::ctr_type words = philox4x64_R(10, counter, key);
      for (int k = 0; k < 4; ++k) set_lane(block_[k], i, words.v[k]);
    }
  }

  Word<Real> seed_, stream_env_, episode_, step_;
  std::uint64_t stream_;
  std::uint32_t served_;
  std::uint64_t draw_ = 0;
  Word<Real> block_[4] = {};  ///< 0 in lanes that are not served
};

}  // namespace skybody
