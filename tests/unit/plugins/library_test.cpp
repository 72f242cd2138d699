// The handshake: refused libraries and their messages.
#include "core/plugin_host/library.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "core/base/math/hash.h"
#include "core/base/simd/fp_environment.h"
#include "core/base/simd/isa.h"
#include "core/base/system/plugin_call_trace.h"
#include "core/plugin_host/descriptor.h"
#include "core/plugin_host/registry.h"
#include "tests/unit/plugins/small_world.h"

namespace skybody {
namespace {

using std::filesystem::path;
using testing::HasSubstr;

void expect_refused(const path& file, LoadFailure reason, const std::string& message) {
  try {
    const PluginLibrary library(file);
    FAIL() << file << " was accepted";
  } catch (const PluginLoadError& e) {
    EXPECT_EQ(e.what(), std::filesystem::weakly_canonical(file).string() + ": " + message);
    EXPECT_EQ(static_cast<int>(e.reason()), static_cast<int>(reason));
  }
}

constexpr const char* kNoSymbol =
    "is no plugin: it does not export `skybody_plugin_library`; a plugin says "
    "SKYBODY_PLUGIN(Class, name, version, doc) once";

/// If the file shrinks during the check, SIGBUS ends the process: the watcher must have the file's
/// name.
TEST(PluginLibrary, IsWatchedWhileItsFileIsChecked) {
  const test::Folder folder;
  const path file = std::filesystem::canonical(folder.path()) / "short.so";
  std::ofstream(file) << "\x7f"
                      << "ELF";
  PluginCallTrace found{};
  watch_plugins(&found);
  EXPECT_THROW(PluginLibrary{file}, PluginLoadError);
  watch_plugins(nullptr);
  EXPECT_EQ(found.file, file.string());
  EXPECT_EQ(found.phases, 1u);
}

TEST(PluginLibrary, LoadsAGoodOne) {
  const PluginLibrary library(test::good_plugins() / "lane_controller.so");
  ASSERT_EQ(library.plugins().size(), 1u);
  EXPECT_STREQ(library.plugins()[0]->name, "lane_controller");
  EXPECT_EQ(library.plugins()[0]->vectorized, 1u);
  EXPECT_EQ(library.plugins()[0]->state_words, 5u);
}

TEST(PluginLibrary, RefusesAnotherApiVersion) {
  expect_refused(test::bad_plugins() / "wrong_version.so", LoadFailure::kWrongVersion,
                 "was built for plugin API 9, this Skybody has 8: rebuild it against this Skybody");
}

TEST(PluginLibrary, RefusesAnotherMagic) {
  expect_refused(test::bad_plugins() / "wrong_magic.so", LoadFailure::kWrongMagic,
                 "is no plugin: `skybody_plugin_library` begins with 0000000000001234 instead of "
                 "59444f4259424b53: rebuild it against this Skybody");
}

TEST(PluginLibrary, RefusesAnotherLayout) {
  const std::string ours = std::to_string(sizeof(SkybodyLanes));
  const std::string theirs = std::to_string(sizeof(SkybodyLanes) - 16);
  expect_refused(test::bad_plugins() / "wrong_size.so", LoadFailure::kWrongSize,
                 "its SkybodyLanes has " + theirs + " bytes, this Skybody's has " + ours +
                     ": rebuild it against this Skybody");
  expect_refused(
      test::bad_plugins() / "wrong_structures.so", LoadFailure::kWrongSize,
      "its plugin structures differ from this Skybody's: rebuild it against this Skybody");
}

TEST(PluginLibrary, RecognisesWhatIsNoPluginWithoutRunningIt) {
  expect_refused(test::bad_plugins() / "missing_symbol.so", LoadFailure::kNoPlugin, kNoSymbol);
}

TEST(PluginLibrary, RefusesATruncatedFile) {
  const test::Folder folder;
  const path whole = test::good_plugins() / "lane_controller.so", part = folder.path() / "part.so";
  std::filesystem::copy_file(whole, part);
  for (const std::uintmax_t size : {std::uintmax_t{0}, std::uintmax_t{40}, std::uintmax_t{1000},
                                    std::filesystem::file_size(whole) / 4}) {
    std::filesystem::resize_file(part, size);
    try {
      const PluginLibrary library(part);
      ADD_FAILURE() << size << " bytes were accepted";
    } catch (const PluginLoadError& e) {
      const std::string text = e.what();
      EXPECT_EQ(text.find(part.string() + ": cannot be loaded: "), 0u) << text;
      EXPECT_NE(text.find("; build or copy it again"), std::string::npos) << text;
      EXPECT_EQ(text.find(part.string(), 1), std::string::npos) << text;
      EXPECT_EQ(static_cast<int>(e.reason()), static_cast<int>(LoadFailure::kNotLoadable));
    }
  }
  std::filesystem::resize_file(part, 0);
  expect_refused(part, LoadFailure::kNotLoadable,
                 "cannot be loaded: file too short; build or copy it again");
}

TEST(PluginLibrary, RefusesTextAndMissingFiles) {
  const test::Folder folder;
  std::ofstream(folder.path() / "text.so") << std::string(200, 'x');
  expect_refused(folder.path() / "text.so", LoadFailure::kNotLoadable,
                 "cannot be loaded: invalid ELF header; build or copy it again");
  expect_refused(folder.path() / "none.so", LoadFailure::kNotLoadable, "there is no such file");
}

TEST(PluginLibrary, RefusesOtherFloatingPointFlags) {
#if SKYBODY_HAS_LEVELS
  if (!machine_has(Isa::v3)) GTEST_SKIP() << "the plugin is compiled for x86-64-v3";
#endif
  try {
    const PluginLibrary library(test::bad_plugins() / "fast_math.so");
    FAIL() << "was accepted";
  } catch (const PluginLoadError& e) {
    const std::string text = e.what();
    EXPECT_EQ(static_cast<int>(e.reason()), static_cast<int>(LoadFailure::kFloatingPoint));
    EXPECT_NE(
        text.find("fast_math.so: was compiled with other floating-point flags (its probe gives "),
        std::string::npos)
        << text;
    EXPECT_NE(text.find(" instead of " + to_hex(kFpProbeExpected) +
                        "): link Skybody::plugin_api, and do not use -ffast-math, -Ofast or "
                        "-ffp-contract=fast"),
              std::string::npos)
        << text;
  }
  EXPECT_TRUE(has_standard_fp_environment());
}

TEST(PluginLibrary, UndoesWhatStartUpCodeDoesToTheThread) {
  std::thread([] {
    set_fp_environment();
    const PluginLibrary library(test::good_plugins() / "flush_to_zero.so");
    EXPECT_TRUE(has_standard_fp_environment());
    volatile double tiny = 0x1p-1022;
    EXPECT_GT(tiny * 0.5, 0.0);
  }).join();
}

TEST(PluginLibrary, RefusesNumbersOfParametersAndChoicesThatNoPluginHas) {
  const PluginLibrary library(test::good_plugins() / "lane_controller.so");
  SkybodyPlugin plugin = *library.plugins().front();
  ASSERT_GT(plugin.parameter_count, 0u);
  SkybodyParameter parameter = plugin.parameters[0];
  plugin.parameter_count = 1u << 30;
  EXPECT_THAT(descriptor_problem(plugin), HasSubstr("allowed: at most 1000"));
  parameter.choice_count = 1u << 30;
  plugin.parameters = &parameter;
  plugin.parameter_count = 1;
  EXPECT_THAT(descriptor_problem(plugin), HasSubstr("defaults or choices; allowed: at most 10000"));
}

TEST(PluginLibrary, RefusesFunctionsOnDualNumbersThatAreMissingOrThatNobodyCalls) {
  const PluginLibrary library(test::good_plugins() / "lane_controller.so");
  const SkybodyPlugin& sound = *library.plugins().front();
  ASSERT_NE(sound.kernels[SKYBODY_NUMBER_DUAL][0].control, nullptr);
  const std::string lowest = name(kIsas[0]);

  SkybodyPlugin none = sound;
  for (SkybodyKernels& k : none.kernels[SKYBODY_NUMBER_DUAL]) k = {};
  EXPECT_EQ(descriptor_problem(none), "");

  SkybodyPlugin without_reset = sound;
  without_reset.kernels[SKYBODY_NUMBER_DUAL][0].reset = nullptr;
  EXPECT_EQ(descriptor_problem(without_reset),
            "plugin `lane_controller` has other functions on dual numbers for " + lowest +
                " than on real numbers");

  SkybodyPlugin without_control = sound;
  without_control.kernels[SKYBODY_NUMBER_DUAL][0].control = nullptr;
  EXPECT_EQ(descriptor_problem(without_control),
            "plugin `lane_controller` has no control function on dual numbers for " + lowest);

  SkybodyPlugin with_goal = sound;
  with_goal.kernels[SKYBODY_NUMBER_DUAL][0].goal =
      [](const void*, const SkybodyLanes*, const std::uint64_t*, const double*, double*) {};
  EXPECT_EQ(
      descriptor_problem(with_goal),
      "plugin `lane_controller` has a sense, randomize or goal function on dual numbers for " +
          lowest + ", which nobody calls");
}

TEST(PluginLibrary, HasFunctionsOnDualNumbersOfSmoothPluginsAlone) {
  const PluginLibrary plain(test::good_plugins() / "plain_controller.so");
  const PluginLibrary smooth(test::good_plugins() / "lane_task.so");
  for (int i = 0; i < kIsaCount; ++i) {
    const SkybodyKernels& none = plain.plugins().front()->kernels[SKYBODY_NUMBER_DUAL][i];
    EXPECT_EQ(none.control, nullptr);
    EXPECT_EQ(none.reset, nullptr);
    const SkybodyKernels& some = smooth.plugins().front()->kernels[SKYBODY_NUMBER_DUAL][i];
    EXPECT_NE(some.evaluate, nullptr);
    EXPECT_NE(some.process, nullptr);
    EXPECT_NE(some.reset, nullptr);
    EXPECT_EQ(some.goal, nullptr);
  }
}

TEST(PluginLibrary, RefusesIncompleteAndContradictoryDescriptors) {
  expect_refused(test::bad_plugins() / "no_kernels.so", LoadFailure::kBadDescription,
                 "plugin `no_kernels` has no control function for v3");
  expect_refused(test::bad_plugins() / "bad_name.so", LoadFailure::kBadDescription,
                 "plugin `Bad-Name` has a bad name: lower-case letters, digits and underscores, a "
                 "letter first");
  expect_refused(test::bad_plugins() / "bad_default.so", LoadFailure::kBadDescription,
                 "plugin `bad_default` declares parameter `tau`: its default 0.5 is outside its "
                 "range 1..2");
  expect_refused(test::bad_plugins() / "throws_in_constructor.so", LoadFailure::kBadDescription,
                 "its constructor failed: no licence");
}

}  // namespace
}  // namespace skybody
