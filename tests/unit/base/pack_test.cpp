// Packs, masks and words: lanes in and out, blends, and the connectives of masks.
#include "core/base/simd/pack.h"

#include <gtest/gtest.h>

#include <type_traits>

namespace skybody {
namespace {

template <class Real>
class Lanes : public ::testing::Test {};
using Reals = ::testing::Types<double, Pack<2>, Pack<4>, Pack<8>>;
TYPED_TEST_SUITE(Lanes, Reals);

TYPED_TEST(Lanes, LoadAndStoreKeepOrderAndNeedNoAlignment) {
  constexpr int n = kLanesOf<TypeParam>;
  double memory[18];
  for (int i = 0; i < 18; ++i) memory[i] = i;
  const TypeParam x = load_lanes<TypeParam>(memory + 1);
  for (int i = 0; i < n; ++i) EXPECT_EQ(lane(x, i), 1.0 + i);
  store_lanes(memory + 9, x * 2.0);
  EXPECT_EQ(memory[8], 8.0);
  for (int i = 0; i < n; ++i) EXPECT_EQ(memory[9 + i], 2.0 + 2 * i);
  EXPECT_EQ(memory[9 + n], 9.0 + n);
}

TYPED_TEST(Lanes, MaskedStoreLeavesOtherLanes) {
  constexpr int n = kLanesOf<TypeParam>;
  for (std::uint32_t bits = 0; bits < (1u << n); ++bits) {
    double memory[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    std::uint64_t words[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    const auto mask = mask_from_bits<TypeParam>(bits);
    store_lanes(memory, TypeParam(9.0), mask);
    store_words(words, Word<TypeParam>(9), mask);
    for (int i = 0; i < n; ++i) {
      EXPECT_EQ(memory[i], (bits >> i & 1) ? 9.0 : i);
      EXPECT_EQ(words[i], (bits >> i & 1) ? 9u : static_cast<unsigned>(i));
    }
  }
}

TYPED_TEST(Lanes, MasksGoToBitsAndBack) {
  constexpr int n = kLanesOf<TypeParam>;
  const std::uint32_t full = (1u << n) - 1;
  for (std::uint32_t bits = 0; bits <= full; ++bits) {
    const auto mask = mask_from_bits<TypeParam>(bits);
    EXPECT_EQ(bits_from_mask(mask), bits);
    EXPECT_EQ(any(mask), bits != 0);
    EXPECT_EQ(all(mask), bits == full);
    EXPECT_EQ(none(mask), bits == 0);
    EXPECT_EQ(bits_from_mask(!mask), full & ~bits);
    for (int i = 0; i < n; ++i) EXPECT_EQ(lane(mask, i), (bits >> i & 1) != 0);
    const auto odd = mask_from_bits<TypeParam>(0x55);
    EXPECT_EQ(bits_from_mask(logical_and(mask, odd)), bits & 0x55 & full);
    EXPECT_EQ(bits_from_mask(logical_or(mask, odd)), (bits | 0x55) & full);
    EXPECT_EQ(bits_from_mask(logical_not(mask)), full & ~bits);
    EXPECT_EQ(bits_from_mask(MaskOf<TypeParam>(mask && odd)), bits & 0x55 & full);
    EXPECT_EQ(bits_from_mask(MaskOf<TypeParam>(mask || odd)), (bits | 0x55) & full);
  }
  EXPECT_TRUE(all(MaskOf<TypeParam>(true)));
  EXPECT_TRUE(none(MaskOf<TypeParam>(false)));
}

TYPED_TEST(Lanes, SelectTakesEachLaneFromItsSide) {
  constexpr int n = kLanesOf<TypeParam>;
  TypeParam x = 0.0;
  for (int i = 0; i < n; ++i) set_lane(x, i, i - 1.5);
  const TypeParam chosen = select(x < 0.0, 1.0 - x, x);
  for (int i = 0; i < n; ++i) EXPECT_EQ(lane(chosen, i), i < 2 ? 2.5 - i : i - 1.5);
  const Word<TypeParam> word = select(x < 0.0, Word<TypeParam>(7), Word<TypeParam>(8));
  for (int i = 0; i < n; ++i) EXPECT_EQ(lane(word, i), i < 2 ? 7u : 8u);
}

TYPED_TEST(Lanes, NanAndSignedZeroSurviveBroadcastAndComparison) {
  const TypeParam nan(__builtin_nan("")), minus_zero(-0.0);
  EXPECT_TRUE(none(nan == nan));
  EXPECT_TRUE(all(nan != nan));
  EXPECT_TRUE(none(nan < 1.0) && none(nan >= 1.0));
  for (int i = 0; i < kLanesOf<TypeParam>; ++i) {
    EXPECT_EQ(lane(bit_cast_word(minus_zero), i), 0x8000000000000000ull);
    EXPECT_EQ(lane(bit_cast_word(-TypeParam(0.0)), i), 0x8000000000000000ull);
  }
}

TYPED_TEST(Lanes, WordsWrapShiftAndConvertExactly) {
  using W = Word<TypeParam>;
  const W big(0xfedcba9876543210ull);
  const int last = kLanesOf<TypeParam> - 1;
  EXPECT_EQ(lane(W(big * W(0x123456789abcdefull)), last),
            0xfedcba9876543210ull * 0x123456789abcdefull);
  EXPECT_EQ(lane(W(W(0) - 1), last), ~std::uint64_t{0});
  EXPECT_EQ(lane(W((big >> 4) ^ (big << 8)), last),
            (0xfedcba9876543210ull >> 4) ^ (0xfedcba9876543210ull << 8));
  EXPECT_TRUE(all(W(1) < big) && none(big < W(1)) && all(big == big));
  for (const std::uint64_t w : {0ull, 1ull, 4503599627370495ull}) {
    EXPECT_EQ(lane(to_real(W(w)), last), static_cast<double>(w));
    EXPECT_EQ(lane(to_word(to_real(W(w))), last), w);
  }
  EXPECT_EQ(lane(bit_cast_real(bit_cast_word(TypeParam(0.1))), last), 0.1);
}

TYPED_TEST(Lanes, ComparisonsGiveTheRealsMask) {
  static_assert(std::is_same<decltype(TypeParam(1.0) < 2.0), MaskOf<TypeParam>>::value, "");
  static_assert(std::is_trivially_copyable<TypeParam>::value, "");
  static_assert(sizeof(TypeParam) == sizeof(double) * kLanesOf<TypeParam>, "");
}

}  // namespace
}  // namespace skybody
