// The table of results, for the terminal and for docs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/fuzz/tally.h"

namespace skybody::fuzz {

/// Facts that hold for all areas.
struct RunFacts {
  std::string command;
  double minutes = 0.0;
  int jobs = 1;
};

/// The table with its sums.
std::string table_text(const std::vector<Tally>& tallies);

/// The table as a page of docs, with machine, commit and command.
void write_markdown(const std::filesystem::path& file, const std::vector<Tally>& tallies,
                    const RunFacts& facts);

}  // namespace skybody::fuzz
