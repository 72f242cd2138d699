#include "tests/fuzz/report.h"

#include <algorithm>
#include <cstdio>

#include "app/report/machine.h"
#include "app/report/text_table.h"
#include "core/version.h"
#include "skybody/git_describe.h"
#include "tests/fuzz/files.h"

namespace skybody::fuzz {
namespace {

std::vector<std::string> titles() {
  std::vector<std::string> row = {"area", "inputs", "refused", "accepted"};
  row.insert(row.end(), kFindingTitles.begin(), kFindingTitles.end());
  row.insert(row.end(), {"slowest [ms]", "inputs/s"});
  return row;
}

std::string whole(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f", value);
  return text;
}

std::vector<std::string> row_of(const Tally& tally) {
  std::vector<std::string> row = {tally.area, std::to_string(tally.inputs()),
                                  std::to_string(tally.refused), std::to_string(tally.accepted)};
  for (const std::uint64_t count : tally.findings) row.push_back(std::to_string(count));
  row.push_back(whole(1e3 * tally.slowest));
  const auto inputs = static_cast<double>(tally.inputs());
  row.push_back(tally.seconds > 0.0 ? whole(inputs / tally.seconds) : "");
  return row;
}

Tally sum_of(const std::vector<Tally>& tallies) {
  Tally sum;
  sum.area = "all";
  for (const Tally& tally : tallies) {
    sum.refused += tally.refused;
    sum.accepted += tally.accepted;
    for (std::size_t k = 0; k < kFindingKinds; ++k) sum.findings[k] += tally.findings[k];
    sum.seconds += tally.seconds;
    sum.slowest = std::max(sum.slowest, tally.slowest);
  }
  return sum;
}

std::vector<std::vector<std::string>> rows_of(const std::vector<Tally>& tallies) {
  std::vector<std::vector<std::string>> rows;
  for (const Tally& tally : tallies) rows.push_back(row_of(tally));
  rows.push_back(row_of(sum_of(tallies)));
  return rows;
}

std::string markdown_row(const std::vector<std::string>& cells) {
  std::string line = "|";
  for (const std::string& cell : cells) line += " " + cell + " |";
  return line + "\n";
}

}  // namespace

std::string table_text(const std::vector<Tally>& tallies) {
  TextTable table(titles());
  for (const auto& row : rows_of(tallies)) table.add(row);
  return table.to_string();
}

void write_markdown(const std::filesystem::path& file, const std::vector<Tally>& tallies,
                    const RunFacts& facts) {
  std::string text = "`" + facts.command + "` on " + machine_name() + " (" + processor_name() +
                     ", " + std::to_string(facts.jobs) + " processes at a time), Skybody " +
                     SKYBODY_GIT_DESCRIBE + ", " + whole(facts.minutes) + " minutes.\n\n";
  text += markdown_row(titles());
  text += markdown_row(std::vector<std::string>(titles().size(), "---"));
  for (const auto& row : rows_of(tallies)) text += markdown_row(row);
  write_bytes(file, text);
}

}  // namespace skybody::fuzz
