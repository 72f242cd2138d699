// Turns single bits of a file and counts what becomes of reading it, each time in a child process.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>

namespace skybody::test {

/// What became of reading damaged files.
struct FlipCounts {
  int refused = 0;    ///< an Error
  int same = 0;       ///< read, with the content of the whole file
  int different = 0;  ///< read without complaint, with other content
  int crashed = 0;
  int hung = 0;  ///< ten seconds
  bool operator==(const FlipCounts&) const = default;
};
void PrintTo(const FlipCounts& counts, std::ostream* out);

/// SKYBODY_FLIPS, or `usual` where that is not set.
int flips_wanted(int usual);

/// Turns `flips` bits, one at a time, drawn by a fixed seed, or all where there are no more. Bits
/// are those of bytes that are not zero, or that follow such a one closely.
/// @param read  the content of `file` as one text, all that its user would see; throws Error
FlipCounts flip_bits(const std::filesystem::path& file, int flips,
                     const std::function<std::string()>& read);

}  // namespace skybody::test
