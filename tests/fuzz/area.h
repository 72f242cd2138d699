// One kind of input, and what a right answer to it is.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tests/fuzz/finding.h"
#include "tests/fuzz/mutator.h"

namespace skybody::fuzz {

/// Both are right, as long as nothing else happens.
enum class Answer { kRefused, kAccepted };

/// What areas need to make their seeds.
struct AreaOptions {
  std::filesystem::path folder;  ///< to write into
  std::filesystem::path policy;  ///< a valid policy.h5; empty: one is made
};

/// So many inputs of a block are run again and again to see whether memory grows.
inline constexpr std::uint64_t kLeakInputs = 12;
/// Smallest growth that is no noise of malloc's [bytes].
inline constexpr std::size_t kSmallLeak = 16;

/// Made once in the parent process; begin() and run() are called in children.
class Area {
 public:
  virtual ~Area() = default;

  const Material& material() const { return material_; }
  /// Before the first run() of a process, with a folder that no other process uses.
  virtual void begin(const std::filesystem::path& folder) = 0;
  /// @param thorough  asks for checks that take longer, such as a second run that must be the same
  /// @throws Finding if the answer is wrong; any other exception is a finding as well
  virtual Answer run(const std::string& input, bool thorough) = 0;
  /// Growth of the heap that counts as a leak, per repetition of kLeakInputs inputs [bytes]; 0:
  /// leaks are not looked for.
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

/// The k-th input of an area: it follows from seed, area and k alone.
inline std::string make_input(const AreaRow& row, const Area& area, std::uint64_t seed,
                              std::uint64_t k) {
  Dice dice(seed, row.name, k);
  return make_input(dice, area.material(), row.mutators);
}

}  // namespace skybody::fuzz
