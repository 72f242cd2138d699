#include "core/replay/replay_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <utility>

#include "core/base/system/error.h"
#include "core/base/system/printable.h"
#include "core/model/layout.h"

namespace skybody {
namespace {

constexpr std::size_t kMostOfGroup = 4;  // values of each group in a report

std::string number(double value, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

bool same_bits(float a, float b) {
  return (std::isnan(a) && std::isnan(b)) || std::memcmp(&a, &b, sizeof a) == 0;
}

double as_double(std::uint64_t word) {
  double value;
  std::memcpy(&value, &word, sizeof value);
  return value;
}

bool same_word(std::uint64_t a, std::uint64_t b) {
  return a == b || (std::isnan(as_double(a)) && std::isnan(as_double(b)));
}

/// A word as the most likely number: header words and counters are whole numbers, which would be
/// denormal as doubles.
std::string word_text(std::uint64_t word, std::size_t index) {
  const double value = as_double(word);
  const bool is_real =
      index >= kHeaderSize && (value == 0.0 || std::isnan(value) || std::fabs(value) >= 2.3e-308);
  return is_real ? number(value, 17) : std::to_string(word);
}

void compare_observations(const ReplayHeader& header, const ReplayRow& a, const ReplayRow& b,
                          std::vector<ReplayDifference>& out) {
  for (std::size_t k = 0; k < std::min(a.observation.size(), b.observation.size()); ++k) {
    const float x = a.observation[k], y = b.observation[k];
    if (same_bits(x, y)) continue;
    out.push_back({"observation " + printable(header.observation_names.at(k)),
                   number(static_cast<double>(x), 9), number(static_cast<double>(y), 9)});
  }
}

void compare_states(const ReplayHeader& header, const ReplayRow& a, const ReplayRow& b,
                    std::vector<ReplayDifference>& out) {
  for (std::size_t k = 0; k < std::min(a.state.size(), b.state.size()); ++k) {
    if (same_word(a.state[k], b.state[k])) continue;
    out.push_back({"state " + printable(header.state_names.at(k)), word_text(a.state[k], k),
                   word_text(b.state[k], k)});
  }
}

std::string padded(std::string text, std::size_t width) {
  text.resize(std::max(width, text.size()), ' ');
  return text;
}

/// The group of a value: "observation", "state u", "reward".
std::string group_of(const std::string& name) {
  const std::size_t first = name.find(' ');
  if (name.rfind("state ", 0) != 0) return name.substr(0, std::min(first, name.find('[')));
  return name.substr(0, name.find_first_of(" [", first + 1));
}

/// The first values of each group; a row without values gives the number of others in a group.
std::vector<ReplayDifference> shortened(const std::vector<ReplayDifference>& differences) {
  std::vector<ReplayDifference> rows;
  for (std::size_t k = 0; k < differences.size();) {
    const std::string group = group_of(differences[k].name);
    std::size_t end = k;
    while (end < differences.size() && group_of(differences[end].name) == group) ++end;
    const std::size_t shown = std::min(end, k + kMostOfGroup);
    for (; k < shown; ++k) rows.push_back(differences[k]);
    if (shown < end) {
      rows.push_back({group + ": " + std::to_string(end - shown) + " more", "", ""});
    }
    k = end;
  }
  return rows;
}

std::string table(const std::vector<ReplayDifference>& differences, const std::string& first,
                  const std::string& second) {
  std::vector<ReplayDifference> rows = shortened(differences);
  rows.insert(rows.begin(), {"", first, second});
  std::size_t name = 0, value = 0;
  for (const ReplayDifference& row : rows) {
    name = std::max(name, row.name.size());
    value = std::max(value, row.first.size());
  }
  std::string text;
  for (const ReplayDifference& row : rows) {
    text += "  " + (row.second.empty() ? row.name
                                       : padded(row.name, name) + "  " + padded(row.first, value) +
                                             "  " + row.second);
    text += "\n";
  }
  return text;
}

}  // namespace

std::vector<ReplayDifference> compare_rows(const ReplayHeader& header, const ReplayRow& first,
                                           const ReplayRow& second) {
  std::vector<ReplayDifference> out;
  const auto compare = [&](const char* name, auto a, auto b) {
    if (a != b) out.push_back({name, std::to_string(a), std::to_string(b)});
  };
  compare("episode", first.episode, second.episode);
  compare("step", first.episode_step, second.episode_step);
  compare("was_reset", static_cast<int>(first.was_reset), static_cast<int>(second.was_reset));
  compare("status", first.status, second.status);
  if (!same_bits(first.reward, second.reward)) {
    out.push_back({"reward", number(static_cast<double>(first.reward), 9),
                   number(static_cast<double>(second.reward), 9)});
  }
  compare_observations(header, first, second, out);
  compare_states(header, first, second, out);
  return out;
}

void ReplayReport::add(ReplayParting parting) {
  ++parted;
  if (!where || parting.place < where->place) where = std::move(parting);
}

std::string ReplayReport::text(const ReplayHeader& header, const std::string& first,
                               const std::string& second) const {
  if (identical()) return "identical: " + std::to_string(transitions) + " transitions\n";
  std::string text = remark.empty() ? "" : remark + "\n";
  if (!where) return text;
  const ReplayRow& row = where->first;
  text += "first difference: environment " + std::to_string(row.env) + ", transition " +
          std::to_string(where->transition) + " (episode " + std::to_string(row.episode) +
          ", step " + std::to_string(row.episode_step) + (row.was_reset ? ", a reset" : "") +
          "); " + std::to_string(parted) + " of " + std::to_string(header.envs) +
          " environments differ\n";
  if (!where->differences.empty()) return text + table(where->differences, first, second);
  const bool has_states = !header.state_names.empty();
  return text + (has_states ? "  only images differ, and the recording has only their hash\n"
                            : "  only state words or images differ: record with states to see "
                              "which words\n");
}

namespace {

/// The differences between the k-th transitions of an environment, first those of its inputs.
ReplayParting describe(const ReplayReader& first, const ReplayReader& second, int env,
                       std::size_t k) {
  ReplayParting parting;
  parting.place = first.place(env, k);
  parting.transition = k + 1;
  parting.first = first.row(parting.place);
  parting.second = second.row(second.place(env, k));
  const std::vector<float> a = first.action(env, k), b = second.action(env, k);
  if (a.empty() != b.empty()) {
    parting.differences.push_back(
        {"sent", a.empty() ? "reset" : "action", b.empty() ? "reset" : "action"});
  }
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (same_bits(a[i], b[i])) continue;
    parting.differences.push_back({"action[" + std::to_string(i) + "]",
                                   number(static_cast<double>(a[i]), 9),
                                   number(static_cast<double>(b[i]), 9)});
  }
  for (ReplayDifference& d : compare_rows(first.header(), parting.first, parting.second)) {
    parting.differences.push_back(std::move(d));
  }
  return parting;
}

void check_comparable(const ReplayReader& first, const ReplayReader& second) {
  const ReplayHeader &a = first.header(), &b = second.header();
  const auto refuse = [&](const std::string& what) {
    throw Error("these recordings cannot be compared: " + first.file().string() + " and " +
                second.file().string() + " differ in " + what);
  };
  if (a.envs != b.envs) {
    refuse("the number of environments, " + std::to_string(a.envs) + " and " +
           std::to_string(b.envs));
  }
  if (a.columns != b.columns || a.observation_names != b.observation_names)
    refuse("what they observe");
  if (a.action_size != b.action_size) refuse("the width of an action");
}

}  // namespace

ReplayReport compare_replays(const ReplayReader& first, const ReplayReader& second) {
  check_comparable(first, second);
  ReplayReport report;
  std::vector<std::size_t> next(static_cast<std::size_t>(first.header().envs));
  std::vector<std::uint8_t> parted(next.size());
  for (std::size_t at = 0; at < first.transitions(); ++at) {  // rows are read in their order
    const ReplayRow row = first.row(at);
    const auto env = static_cast<std::size_t>(row.env);
    const std::size_t k = next[env]++;
    if (k >= second.transitions(row.env)) continue;
    ++report.transitions;
    if (parted[env] != 0) continue;
    const ReplayRow other = second.row(second.place(row.env, k));
    const bool same_rows = compare_rows(first.header(), row, other).empty();
    if (row.hash == other.hash && same_rows) continue;
    parted[env] = 1;
    if (row.hash == other.hash) report.remark = kRowsChanged;
    report.add(describe(first, second, row.env, k));
  }
  std::size_t shorter[2] = {0, 0};  // transitions missing in the first, or in the second
  for (int env = 0; env < first.header().envs; ++env) {
    const std::size_t a = first.transitions(env), b = second.transitions(env);
    shorter[0] += b - std::min(a, b);
    shorter[1] += a - std::min(a, b);
  }
  for (const int which : {0, 1}) {
    if (shorter[which] == 0) continue;
    report.remark += (report.remark.empty() ? "" : "\n") +
                     std::string(which == 0 ? first.file() : second.file()) + " lacks " +
                     std::to_string(shorter[which]) + " transitions that the other has";
  }
  return report;
}

}  // namespace skybody
