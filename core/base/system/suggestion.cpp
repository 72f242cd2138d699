#include "core/base/system/suggestion.h"

#include <algorithm>
#include <cstdlib>

namespace skybody {
namespace {

constexpr std::size_t kLongestCompared = 100;  // [bytes]; longer words are not misspellings
constexpr std::size_t kMostCompared = 200;     // candidates; limits the run time
constexpr std::size_t kMostListed = 40;        // names in a message; more are not helpful

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// Optimal string alignment distance.
int edit_distance(std::string_view a, std::string_view b) {
  const int n = static_cast<int>(a.size());
  const int m = static_cast<int>(b.size());
  std::vector<std::vector<int>> d(n + 1, std::vector<int>(m + 1));
  for (int i = 0; i <= n; ++i) d[i][0] = i;
  for (int j = 0; j <= m; ++j) d[0][j] = j;
  for (int i = 1; i <= n; ++i) {
    for (int j = 1; j <= m; ++j) {
      const int cost = lower(a[i - 1]) == lower(b[j - 1]) ? 0 : 1;
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + cost});
      const bool swapped = i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) &&
                           lower(a[i - 2]) == lower(b[j - 1]);
      if (swapped) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[n][m];
}

}  // namespace

std::string join(const std::vector<std::string>& words, std::string_view separator) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += separator;
    text += words[i];
  }
  return text;
}

std::string join_first(const std::vector<std::string>& words) {
  if (words.size() <= kMostListed) return join(words);
  const std::vector<std::string> first(words.begin(), words.begin() + kMostListed);
  return join(first) + " and " + std::to_string(words.size() - kMostListed) + " more";
}

std::string closest(std::string_view word, const std::vector<std::string>& candidates) {
  if (word.size() > kLongestCompared || candidates.size() > kMostCompared) return "";
  const int limit = std::max<int>(1, static_cast<int>(word.size()) / 3);
  int best = limit + 1;
  std::string found;
  for (const std::string& candidate : candidates) {
    const auto longer = static_cast<int>(candidate.size()) - static_cast<int>(word.size());
    if (candidate.size() > kLongestCompared || std::abs(longer) > limit) continue;
    const int distance = edit_distance(word, candidate);
    if (distance < best) {
      best = distance;
      found = candidate;
    }
  }
  return found;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& candidates,
                       std::string_view noun) {
  const std::string found = closest(word, candidates);
  if (!found.empty()) return "; did you mean `" + found + "`?";
  if (candidates.empty()) return "";
  return "; " + std::string(noun) + ": " + join_first(candidates);
}

}  // namespace skybody
