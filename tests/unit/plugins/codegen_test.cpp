// Lane code must be inlined into the kernels. A separate function on packs is compiled for the
// baseline: it is slow, and does not expect packs in the caller's registers. The kernels for v3 and
// v4 must use wide registers.
#include <gtest/gtest.h>

#include <cstdio>
#include <deque>
#include <filesystem>
#include <map>
#include <string>

#include "core/base/simd/isa.h"
#include "tests/unit/plugins/small_world.h"

namespace skybody {
namespace {

/// Lines of a command's output.
std::vector<std::string> output_of(const std::string& command) {
  std::vector<std::string> lines;
  FILE* pipe = popen((command + " 2>/dev/null").c_str(), "r");
  char line[4096];
  while (pipe != nullptr && fgets(line, sizeof line, pipe) != nullptr) lines.emplace_back(line);
  if (pipe != nullptr) pclose(pipe);
  return lines;
}

bool kernels_are_inlined() {
#if defined(NDEBUG)  // a release build: tests themselves are not optimised
  return true;
#else
  return false;
#endif
}

/// Tests if a disassembled function is a kernel of an instruction set (core/base/simd/kernels.h).
bool is_kernel(const std::string& function, Isa isa) {
  return function.find("::detail::Kernel<") != std::string::npos &&
         function.find(">::" + std::string(name(isa)) + "(") != std::string::npos;
}

std::vector<std::filesystem::path> plugin_files() {
  std::vector<std::filesystem::path> files;
  for (const std::filesystem::path& folder :
       {test::good_plugins(), std::filesystem::path(SKYBODY_BINARY_DIR "/lib/skybody/plugins")}) {
    std::error_code none;
    for (const auto& item : std::filesystem::directory_iterator(folder, none)) {
      if (item.path().extension() == ".so") files.push_back(item.path());
    }
  }
  return files;
}

TEST(Codegen, NoLaneCodeOutsideTheKernels) {
  if (!kernels_are_inlined()) GTEST_SKIP() << "this build does not inline kernels";
  ASSERT_FALSE(plugin_files().empty());
  for (const std::filesystem::path& file : plugin_files()) {
    const auto symbols = output_of("nm -C '" + file.string() + "'");
    if (symbols.empty()) GTEST_SKIP() << "no nm, or no symbols";
    for (const std::string& line : symbols) {
      EXPECT_EQ(line.find("Pack<"), std::string::npos) << file << ": " << line;
    }
  }
}

#if SKYBODY_HAS_LEVELS
TEST(Codegen, WideKernelsUseWideRegisters) {
  if (!kernels_are_inlined()) GTEST_SKIP() << "this build does not inline kernels";
  const std::string file = (test::good_plugins() / "lane_controller.so").string();
  std::string function;
  int ymm = 0, zmm = 0, ymm_in_v2 = 0;
  const auto lines = output_of("objdump -d -C --no-show-raw-insn '" + file + "'");
  if (lines.empty()) GTEST_SKIP() << "no objdump";
  for (const std::string& line : lines) {
    if (line.ends_with(">:\n")) function = line;
    if (function.find("::Control<") == std::string::npos) continue;
    const bool product = line.find("vmulpd") != std::string::npos;
    const bool v3 = is_kernel(function, Isa::v3);
    const bool v4 = is_kernel(function, Isa::v4);
    const bool v2 = is_kernel(function, Isa::v2);
    ymm += v3 && product && line.find("%ymm") != std::string::npos;
    zmm += v4 && product && line.find("%zmm") != std::string::npos;
    ymm_in_v2 += v2 && line.find("%ymm") != std::string::npos;
  }
  EXPECT_GE(ymm, has_kernels(Isa::v3) ? 8 : 0);  // four gains, four shares
  EXPECT_GE(zmm, has_kernels(Isa::v4) ? 8 : 0);
  EXPECT_EQ(ymm_in_v2, 0);
}

/// g++ 12 fuses products with sums and differences in vector code regardless of -ffp-contract,
/// which gives other bits on v3 and v4 than on v2 (SKYBODY_UNFUSED_OPTION). Networks fuse on
/// purpose, in a library of their own.
TEST(Codegen, NothingInTheStepPathFusesProductsAndSums) {
  std::vector<std::filesystem::path> files = plugin_files();
  files.emplace_back(SKYBODY_BINARY_DIR "/lib/libskybody.so");
  for (const std::filesystem::path& file : files) {
    const std::vector<std::string> code =
        output_of("objdump -d -C --no-show-raw-insn '" + file.string() + "'");
    if (code.empty()) GTEST_SKIP() << "no objdump";
    std::string function;
    for (const std::string& line : code) {
      if (line.ends_with(">:\n")) function = line;
      const bool fuses =
          line.find("\tvfm") != std::string::npos || line.find("\tvfnm") != std::string::npos;
      EXPECT_FALSE(fuses) << file << ": " << function << line;
    }
  }
}

/// A vector of values read one by one, such as a robot's position, velocity and attitude in code
/// for one lane, on which g++ then computes jointly.
class LaneByLaneReads {
 public:
  void see(const std::string& line) {
    const bool reads =
        line.find(",%xmm") != std::string::npos &&
        (line.find("vmovsd ") != std::string::npos || line.find("vmovhpd ") != std::string::npos) &&
        line.find("(%r") != std::string::npos && line.find("(%rsp)") == std::string::npos;
    recent_.push_back(reads);
    reads_ += reads;
    if (recent_.size() <= kReach) return;
    reads_ -= recent_.front();
    recent_.pop_front();
  }
  bool are_near() const { return reads_ >= 8; }

 private:
  static constexpr std::size_t kReach = 50;  // lines
  std::deque<bool> recent_;
  int reads_ = 0;
};

/// g++ 12 splits some selections and stores into lanes and reassembles them from eight registers of
/// one lane each: by pairs, then four lanes to half of the vector, then both halves. The test
/// counts the last kind, because pairs alone also occur as pointers in code for one lane.
TEST(Codegen, WideKernelsOfShippedPluginsAreNotTakenApart) {
  if (!kernels_are_inlined()) GTEST_SKIP() << "this build does not inline kernels";
  if (!has_kernels(Isa::v4)) GTEST_SKIP() << "this build has no kernels for v4";
  for (const std::filesystem::path& file : plugin_files()) {
    const std::string plugin = file.stem().string();
    // Written for one lane; g++ vectorizes the lidar's loops over rays.
    if (plugin.starts_with("plain_") || plugin == "lidar") continue;
    std::string function;
    std::map<std::string, int> joined;
    LaneByLaneReads reads;
    const std::vector<std::string> code =
        output_of("objdump -d -C --no-show-raw-insn '" + file.string() + "'");
    if (code.empty()) GTEST_SKIP() << "no objdump";
    for (const std::string& line : code) {
      if (line.ends_with(">:\n")) function = line;
      if (!is_kernel(function, Isa::v4)) continue;
      reads.see(line);
      const bool joins = line.find("vinsertf64x4") != std::string::npos ||
                         line.find("vinserti64x4") != std::string::npos;
      joined[function] += joins && !reads.are_near();
    }
    EXPECT_FALSE(joined.empty()) << file << " has no kernels for v4";
    for (const auto& [name, count] : joined) EXPECT_EQ(count, 0) << file << ": " << name;
  }
}
#endif

}  // namespace
}  // namespace skybody
