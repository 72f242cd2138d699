// The command line of skybody_fuzz.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/fuzz/block.h"

namespace skybody::fuzz {

struct Options {
  std::vector<std::string> areas;  ///< empty: all
  std::uint64_t seed = 1;
  std::uint64_t first = 0;
  std::uint64_t count = 0;         ///< inputs of each area; 0: only the corpus, or see `minutes`
  double minutes = 0.0;            ///< total time instead of a count, shared equally by all areas
  std::uint64_t inputs = 0;        ///< least total of all areas, likewise, beside `minutes`
  bool corpus = false;             ///< runs the areas' seeds and tests/fuzz/corpus first
  std::filesystem::path input;     ///< one file instead of everything else
  std::filesystem::path save;      ///< folder for inputs with findings; empty: they are not saved
  std::filesystem::path markdown;  ///< file for the table
  std::filesystem::path policy;    ///< seed of the policy area
  int jobs = 1;
  bool in_process = false;  ///< run in this process, for a debugger: no child process, no limits
  Limits limits;
  std::string command;  ///< the command line as given

  /// Whether areas have equal time, and not equal counts.
  bool shares_time() const { return minutes > 0.0 || inputs > 0; }
};

/// @returns false if the program must exit; then `status` is its exit status
bool parse_options(int count, char** arguments, Options& options, int& status);

}  // namespace skybody::fuzz
