// Layout of a plugin's State in state words: one 64-bit word per member and environment. With
// dual numbers two words, the second of which is the tangent.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "plugins/api/plugin.h"

namespace skybody {
namespace plugin_export {

/// A Real of three bytes. In a State<ThreeBytes> any other member, or padding, changes the size.
struct ThreeBytes {
  char bytes[3];
};

/// A Real and a Word of one byte. The bytes of a State<RealMember>{} show which members are Real.
struct WordMember {
  bool is_real = false;
  constexpr WordMember() = default;
  constexpr WordMember(std::uint64_t) {}
};
struct RealMember {
  bool is_real = true;
  constexpr RealMember() = default;
  constexpr RealMember(double) {}
};

}  // namespace plugin_export

template <>
struct RealTraits<plugin_export::ThreeBytes> {
  using Mask = bool;
  using Word = plugin_export::ThreeBytes;
  static constexpr int kLanes = 1;
};
template <>
struct RealTraits<plugin_export::RealMember> {
  using Mask = bool;
  using Word = plugin_export::WordMember;
  static constexpr int kLanes = 1;
};

namespace plugin_export {

template <class T>
concept HasStateTemplate = requires {
  typename T::template State<double>;
};

template <class T, class Real, bool = HasStateTemplate<T>>
struct StateOfImpl {
  using type = typename T::template State<Real>;
};
template <class T, class Real>
struct StateOfImpl<T, Real, false> {
  static_assert(std::is_same_v<Real, double>,
                "a plain State belongs to a plugin written for double");
  using type = typename T::State;
};
/// The class's State for `Real`: its template, or its plain struct for double.
template <class T, class Real>
using StateOf = typename StateOfImpl<T, Real>::type;

template <class T>
inline constexpr std::uint32_t kStateWords =
    std::is_empty_v<StateOf<T, double>>
        ? 0u
        : static_cast<std::uint32_t>(sizeof(StateOf<T, double>) / 8);

/// Compile-time checks of a State: only 64-bit words, the same number for every Real.
template <class T>
constexpr void check_state() {
  using Scalar = StateOf<T, double>;
  static_assert(
      std::is_trivially_copyable_v<Scalar>,
      "State must hold plain values: Real, Word<Real>, Vec3<Real>, Quat<Real>, arrays of them");
  static_assert(
      std::is_empty_v<Scalar> || (sizeof(Scalar) % 8 == 0 && alignof(Scalar) == 8),
      "State must consist of 64-bit words: use Real or Word<Real>, not int, bool or float");
  if constexpr (HasStateTemplate<T> && !std::is_empty_v<Scalar>) {
    static_assert(sizeof(StateOf<T, ThreeBytes>) == 3 * kStateWords<T>,
                  "every member of State must be Real or Word<Real> (or a Vec3, Quat or array of "
                  "them), so that it has one 64-bit word per environment");
  }
}

/// The rows of words of a State of dual numbers, `count` of them: a Real takes the rows of the
/// value and the tangent, a Word takes one row.
template <class T>
struct DualRows {
  std::array<std::size_t, 2 * kStateWords<T>> row{};
  std::size_t count = 0;

  constexpr DualRows() {
    using Members = std::array<bool, kStateWords<T>>;
    const auto is_real = std::bit_cast<Members>(StateOf<T, RealMember>{});
    for (std::size_t i = 0; i < is_real.size(); ++i) {
      row[count++] = 2 * i;
      if (is_real[i]) row[count++] = 2 * i + 1;
    }
  }
};

/// The row of words of piece i of a State. A piece has the size of a Word<Real>.
template <class T, class Real>
constexpr std::size_t state_row(std::size_t i) {
  if constexpr (kRowsOf<Real> == 1) {
    return i;
  } else {
    constexpr DualRows<T> kRows;
    static_assert(kRows.count * sizeof(Word<Real>) == sizeof(StateOf<T, Real>),
                  "a State of dual numbers has two pieces for each Real and one for each Word");
    return kRows.row[i];
  }
}

/// Gathers the State of a class from words in lanes: word i of lane l is at words[i * stride + l].
template <class T, class Real>
inline void load_state(StateOf<T, Real>& state, const std::uint64_t* words, std::uint32_t first,
                       std::size_t stride) {
  if constexpr (!std::is_empty_v<StateOf<T, Real>>) {
    constexpr std::size_t kCount = sizeof(state) / sizeof(Word<Real>);
    auto* bytes = reinterpret_cast<unsigned char*>(&state);
    for (std::size_t i = 0; i < kCount; ++i) {
      const std::size_t row = state_row<T, Real>(i);
      const Word<Real> word = load_words<Real>(words + row * stride + first);
      std::memcpy(bytes + i * sizeof(word), &word, sizeof(word));
    }
  }
}

/// Stores a State, for the lanes of `mask`.
template <class T, class Real>
inline void store_state(const StateOf<T, Real>& state, std::uint64_t* words, std::uint32_t first,
                        std::size_t stride, const MaskOf<Real>& mask) {
  if constexpr (!std::is_empty_v<StateOf<T, Real>>) {
    constexpr std::size_t kCount = sizeof(state) / sizeof(Word<Real>);
    const auto* bytes = reinterpret_cast<const unsigned char*>(&state);
    for (std::size_t i = 0; i < kCount; ++i) {
      Word<Real> word;
      std::memcpy(&word, bytes + i * sizeof(word), sizeof(word));
      store_words(words + state_row<T, Real>(i) * stride + first, word, mask);
    }
  }
}

}  // namespace plugin_export
}  // namespace skybody
