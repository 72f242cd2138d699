// The hash chain: order, every bit, strides, and golden values that must never change.
#include "core/base/math/hash.h"

#include <gtest/gtest.h>

#include <set>

namespace skybody {
namespace {

TEST(HashChain, OrderMatters) {
  EXPECT_NE(combine(1, 2), combine(2, 1));
  HashChain a, b;
  a.update(0.0);
  b.update(-0.0);
  EXPECT_NE(a.value(), b.value());
}

TEST(HashChain, LengthMattersEvenForZeros) {
  std::set<std::uint64_t> values;
  HashChain chain;
  for (int i = 0; i < 1000; ++i) {
    values.insert(chain.value());
    chain.update(std::uint64_t{0});
  }
  EXPECT_EQ(values.size(), 1000u);
}

TEST(HashChain, EveryInputBitFlipsAboutHalfOfTheOutput) {
  const std::uint64_t words[3] = {0x0123456789abcdefull, 0, ~std::uint64_t{0}};
  HashChain base;
  base.update(words, 3);
  for (int bit = 0; bit < 192; ++bit) {
    std::uint64_t other[3] = {words[0], words[1], words[2]};
    other[bit / 64] ^= std::uint64_t{1} << (bit % 64);
    HashChain chain;
    chain.update(other, 3);
    const int flipped = __builtin_popcountll(chain.value() ^ base.value());
    EXPECT_GE(flipped, 12) << bit;
    EXPECT_LE(flipped, 52) << bit;
  }
}

TEST(HashChain, StridedWordsHashAsTheSameWordsInARow) {
  std::uint64_t lanes[32];
  for (int i = 0; i < 32; ++i) lanes[i] = static_cast<std::uint64_t>(i) * i;
  HashChain strided, row;
  strided.update(lanes + 3, 4, 8);
  for (int k = 0; k < 4; ++k) row.update(lanes[3 + 8 * k]);
  EXPECT_EQ(strided.value(), row.value());
}

TEST(HashChain, ReadingTheValueDoesNotChangeTheChain) {
  HashChain chain;
  chain.update(std::uint64_t{5});
  const std::uint64_t once = chain.value();
  EXPECT_EQ(chain.value(), once);
}

TEST(HashChain, GoldenValuesStay) {
  const double values[4] = {0.0, 1.0, -2.5, 1e300};
  HashChain chain;
  chain.update(values, 4);
  EXPECT_EQ(to_hex(chain.value()), "5693486d85b1ddc0");
  EXPECT_EQ(to_hex(hash_string("free_body_hover")), "8d5aa87046682db1");
  EXPECT_EQ(to_hex(HashChain().value()), "7acdbb98b1344213");
}

TEST(HashString, PaddingAndLengthAreToldApart) {
  EXPECT_NE(hash_string("abc"), hash_string(std::string("abc\0", 4)));
  EXPECT_NE(hash_string(""), hash_string(std::string(8, '\0')));
  EXPECT_EQ(hash_string("0123456789"), hash_string("0123456789"));
}

TEST(Hex, HasSixteenDigitsAlways) {
  EXPECT_EQ(to_hex(0), "0000000000000000");
  EXPECT_EQ(to_hex(0xfedcba9876543210ull), "fedcba9876543210");
}

}  // namespace
}  // namespace skybody
