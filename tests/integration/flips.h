// Flips single bits of a file and counts the results of reading it, each time in a child process.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>

namespace skybody::test {

/// Counts of the results of reading damaged files.
struct FlipCounts {
  int refused = 0;    ///< refused with an Error
  int same = 0;       ///< read, with the content of the original file
  int different = 0;  ///< read without an error, with other content
  int crashed = 0;
  int hung = 0;  ///< took longer than ten seconds
  bool operator==(const FlipCounts&) const = default;
};
void PrintTo(const FlipCounts& counts, std::ostream* out);

/// SKYBODY_FLIPS, or `usual` if that is not set.
int flips_wanted(int usual);

/// Flips `flips` bits, one at a time, drawn with a fixed seed, or all bits if there are fewer. Only
/// bits of non-zero bytes and of bytes shortly after one are flipped.
/// @param read  reads `file` and returns all content visible to its user as one text; throws Error
FlipCounts flip_bits(const std::filesystem::path& file, int flips,
                     const std::function<std::string()>& read);

}  // namespace skybody::test
