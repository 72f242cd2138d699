// The floating-point mode, the compile-mode probe, the instruction-set choice, the error types.
#include "core/base/simd/fp_environment.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <thread>

#include "core/base/simd/isa.h"
#include "core/base/simd/kernels.h"
#include "core/base/system/error.h"

namespace skybody {

std::uint64_t fp_probe_with_fast_math();  // fp_probe_fast_math.cpp
std::uint64_t fp_probe_contracted();      // fp_probe_contracted.cpp

namespace {

double halve_smallest_normal() {
  volatile double x = 2.2250738585072014e-308;
  return x * 0.5;
}

constexpr std::uint32_t kControlBits = ~0x3fu;

TEST(FpEnvironment, KeepsDenormalsInsideAndRestoresTheCallersModeAfter) {
  const std::uint32_t before = _mm_getcsr();
  const std::uint32_t flushing = kStandardMxcsr | 0x8040;  // FTZ and DAZ, as -Ofast libraries set
  _mm_setcsr(flushing);
  EXPECT_FALSE(has_standard_fp_environment());
  EXPECT_EQ(halve_smallest_normal(), 0.0);
  {
    const FpEnvironment guard;
    EXPECT_TRUE(has_standard_fp_environment());
    EXPECT_GT(halve_smallest_normal(), 0.0);
  }
  const std::uint32_t after = _mm_getcsr();
  _mm_setcsr(before);
  EXPECT_EQ(after & kControlBits, flushing & kControlBits);
}

TEST(FpEnvironment, RestoresRoundingModeAndX87) {
  const std::uint32_t before = _mm_getcsr();
  const std::uint16_t single = 0x007f;
  std::uint16_t inside = 0, after = 0;
  asm volatile("fldcw %0" : : "m"(single));
  _mm_setcsr(kStandardMxcsr | 0x6000);  // towards zero
  {
    const FpEnvironment guard;
    asm volatile("fnstcw %0" : "=m"(inside));
    EXPECT_TRUE(has_standard_fp_environment());
  }
  asm volatile("fnstcw %0" : "=m"(after));
  const std::uint32_t mxcsr = _mm_getcsr();
  set_fp_environment();
  _mm_setcsr(before);
  EXPECT_EQ(inside, kStandardX87);
  EXPECT_EQ(after, single);
  EXPECT_EQ(mxcsr & 0x6000, 0x6000u);
}

TEST(FpEnvironment, WorkersSetTheirOwnMode) {
  bool standard = false;
  std::thread worker([&standard] {
    _mm_setcsr(kStandardMxcsr | 0x8040);
    set_fp_environment();
    standard = has_standard_fp_environment();
  });
  worker.join();
  EXPECT_TRUE(standard);
}

TEST(FpProbe, RecognisesACorrectlyCompiledFile) {
  const FpEnvironment guard;
  EXPECT_EQ(fp_probe(), kFpProbeExpected);
}

TEST(FpProbe, RefusesAFileCompiledWithFastMath) {
  const FpEnvironment guard;
  EXPECT_NE(fp_probe_with_fast_math(), kFpProbeExpected);
}

#if SKYBODY_HAS_LEVELS
TEST(FpProbe, RefusesAFileThatContractsIntoFma) {
  if (!machine_has(Isa::v3)) GTEST_SKIP() << "this machine has no FMA";
  const FpEnvironment guard;
  EXPECT_NE(fp_probe_contracted(), kFpProbeExpected);
}
#endif

class IsaChoice : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const char* value = std::getenv("SKYBODY_ISA")) before_ = value;
  }
  void TearDown() override { setenv("SKYBODY_ISA", before_.c_str(), 1); }
  std::string before_;
};

TEST_F(IsaChoice, TheEnvironmentForcesTheLowestSet) {
  setenv("SKYBODY_ISA", name(kIsas[0]), 1);
  EXPECT_EQ(best_isa(), kIsas[0]);
}

TEST_F(IsaChoice, AnEmptyValueMeansTheHighestSet) {
  setenv("SKYBODY_ISA", "", 1);
  EXPECT_TRUE(machine_has(best_isa()));
  for (const Isa isa : kIsas) EXPECT_FALSE(isa > best_isa() && machine_has(isa));
}

TEST_F(IsaChoice, AWrongValueIsRefusedWithTheAllowedOnes) {
  setenv("SKYBODY_ISA", "avx9", 1);
  try {
    best_isa();
    FAIL() << "accepted avx9";
  } catch (const std::runtime_error& error) {
    const std::string start = "SKYBODY_ISA is \"avx9\"; allowed: " + std::string(name(kIsas[0]));
    EXPECT_EQ(std::string(error.what()).substr(0, start.size()), start);
  }
}

TEST_F(IsaChoice, ASetThatTheMachineLacksIsRefused) {
  const Isa highest = kIsas[kIsaCount - 1];
  if (machine_has(highest)) GTEST_SKIP() << "this machine has every set";
  setenv("SKYBODY_ISA", name(highest), 1);
  EXPECT_THROW(best_isa(), Error);
}

struct WidthOfPack {
  template <int W>
  static int run() {
    return W;
  }
};

TEST(Kernels, OfASetWithoutAnyAreThoseOfTheNextLowerOne) {
  auto* lower = kernel<WidthOfPack>(kIsas[0]);
  ASSERT_NE(lower, nullptr);
  EXPECT_TRUE(has_kernels(kIsas[0])) << "every build runs everywhere";
  for (const Isa isa : kIsas) {
    auto* own = kernel<WidthOfPack>(isa);
    EXPECT_EQ(own == lower, isa == kIsas[0] || !has_kernels(isa)) << name(isa);
    lower = own;
  }
}

TEST(Demand, NamesPlaceConditionAndMessage) {
  SKYBODY_DEMAND(1 + 1 == 2, "arithmetic");
  try {
    SKYBODY_DEMAND(1 + 1 == 3, "arithmetic " + std::string("broke"));
    FAIL();
  } catch (const std::logic_error& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("environment_test.cpp:"), std::string::npos) << what;
    EXPECT_NE(what.find("arithmetic broke (demanded: 1 + 1 == 3)"), std::string::npos) << what;
  }
}

}  // namespace
}  // namespace skybody
