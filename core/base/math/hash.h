// The trajectory hash: an order-dependent chain over 64-bit words.
// Algorithm: per word one xor and two odd multiplications with shifts between (the mixing steps of
// MurmurHash3's fmix64, Austin Appleby, public domain). Each word applies a bijection to the state,
// so two inputs that differ in one word never collide. Not cryptographic.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>

namespace skybody {

/// Hashes words in order; equal sequences give equal values on every machine.
class HashChain {
 public:
  HashChain() = default;
  /// Different seeds give unrelated chains.
  explicit HashChain(std::uint64_t seed) { update(seed); }

  /// One word; narrower integers follow C++'s conversion rules.
  template <class Integer, class = std::enable_if_t<std::is_integral<Integer>::value>>
  void update(Integer value) {
    const std::uint64_t word = static_cast<std::uint64_t>(value);
    state_ = (state_ ^ word) * kFirst;
    state_ = (state_ ^ (state_ >> 32)) * kSecond;
    state_ ^= state_ >> 29;
    ++count_;
  }
  /// The bits of a double: -0 and +0 differ.
  void update(double value) {
    std::uint64_t word;
    std::memcpy(&word, &value, sizeof(word));
    update(word);
  }
  /// n consecutive words.
  void update(const std::uint64_t* words, std::size_t n) { update(words, n, 1); }
  /// n words at a distance of `stride` words.
  void update(const std::uint64_t* words, std::size_t n, std::size_t stride) {
    for (std::size_t i = 0; i < n; ++i) update(words[i * stride]);
  }
  void update(const double* values, std::size_t n) { update(values, n, 1); }
  void update(const double* values, std::size_t n, std::size_t stride) {
    for (std::size_t i = 0; i < n; ++i) update(values[i * stride]);
  }

  /// The hash of all words so far; more words may follow.
  std::uint64_t value() const {
    std::uint64_t h = state_ ^ (count_ * kFirst);
    h = (h ^ (h >> 33)) * 0xff51afd7ed558ccdull;
    h = (h ^ (h >> 33)) * 0xc4ceb9fe1a85ec53ull;
    return h ^ (h >> 33);
  }

 private:
  static constexpr std::uint64_t kFirst = 0x9e3779b97f4a7c15ull;   // 2^64 / golden ratio, odd
  static constexpr std::uint64_t kSecond = 0xd6e8feb86659fd93ull;  // Pelle Evensen's rrmxmx
  std::uint64_t state_ = 0x243f6a8885a308d3ull;                    // fraction of pi
  std::uint64_t count_ = 0;
};

/// The word of a double, with a single word for all NaNs: the sign and payload of a NaN may depend
/// on the order of operands, and differ between double and packs. Other words stay unchanged.
inline std::uint64_t canonical_nan(std::uint64_t word) {
  constexpr std::uint64_t kInfinityBits = 0x7ff0000000000000u;
  return (word & ~(std::uint64_t{1} << 63)) > kInfinityBits ? kInfinityBits + 1 : word;
}

/// One value from two; their order matters.
inline std::uint64_t combine(std::uint64_t first, std::uint64_t second) {
  HashChain chain;
  chain.update(first);
  chain.update(second);
  return chain.value();
}

/// The hash of n bytes: 64-bit little-endian words, the last one padded with zeros, then the
/// length.
inline std::uint64_t hash_bytes(const void* bytes, std::size_t n) {
  const unsigned char* p = static_cast<const unsigned char*>(bytes);
  HashChain chain;
  for (std::size_t i = 0; i < n; i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, p + i, n - i < 8 ? n - i : 8);
    chain.update(word);
  }
  chain.update(static_cast<std::uint64_t>(n));
  return chain.value();
}
inline std::uint64_t hash_string(const std::string& text) {
  return hash_bytes(text.data(), text.size());
}

/// Exactly 16 lower-case hexadecimal digits.
inline std::string to_hex(std::uint64_t value) {
  std::string digits(16, '0');
  for (int i = 15; i >= 0; --i, value >>= 4) digits[i] = "0123456789abcdef"[value & 15];
  return digits;
}

}  // namespace skybody
