// An area: one kind of input, and the check of the program's answer to it.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tests/fuzz/finding.h"
#include "tests/fuzz/mutator.h"

namespace skybody::fuzz {

/// Both are correct answers if no other check fails.
enum class Answer { kRefused, kAccepted };

/// Options from which areas make their seeds.
struct AreaOptions {
  std::filesystem::path folder;  ///< output folder
  std::filesystem::path policy;  ///< a valid policy.h5; empty: one is made
};

/// Number of inputs of a block that are run repeatedly to detect growth of memory.
inline constexpr std::uint64_t kLeakInputs = 12;
/// Smallest growth that is not malloc's noise [bytes].
inline constexpr std::size_t kSmallLeak = 16;

/// Created once in the parent process; begin() and run() are called in child processes.
class Area {
 public:
  virtual ~Area() = default;

  const Material& material() const { return material_; }
  /// Called before the first run() of a process. No other process uses the folder.
  virtual void begin(const std::filesystem::path& folder) = 0;
  /// @param thorough  enables slower checks, such as a second run that must give the same result
  /// @throws Finding if the answer is wrong; any other exception is a finding as well
  virtual Answer run(const std::string& input, bool thorough) = 0;
  /// Growth of the heap per repetition of kLeakInputs inputs that counts as a leak [bytes]; 0
  /// disables leak detection.
  virtual std::size_t smallest_leak() const { return 0; }

 protected:
  Material material_;
};

/// A row of the table of areas.
struct AreaRow {
  const char* name;
  std::unique_ptr<Area> (*make)(const AreaOptions&);
  std::vector<std::span<const Mutator>> mutators;
};

/// All areas, in the order of the table.
const std::vector<AreaRow>& area_rows();

/// The k-th input of an area; a function of seed, area and k only.
inline std::string make_input(const AreaRow& row, const Area& area, std::uint64_t seed,
                              std::uint64_t k) {
  Dice dice(seed, row.name, k);
  return make_input(dice, area.material(), row.mutators);
}

}  // namespace skybody::fuzz
