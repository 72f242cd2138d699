#include "core/io/yaml/fold_warnings.h"

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "core/io/files/text.h"

namespace skybody {
namespace {

constexpr std::size_t kMostLines = 5;  // listed in a folded warning

bool is_digit_at(const std::string& text, std::size_t at) {
  return at < text.size() && text[at] >= '0' && text[at] <= '9';
}

/// The position after a number such as 2.5e-07 that begins at `at`.
std::size_t end_of_number(const std::string& text, std::size_t at) {
  while (is_digit_at(text, at) || (text[at] == '.' && is_digit_at(text, at + 1))) ++at;
  const bool has_exponent =
      at + 1 < text.size() && text[at] == 'e' && (text[at + 1] == '-' || text[at + 1] == '+');
  if (!has_exponent) return at;
  at += 2;
  while (is_digit_at(text, at)) ++at;
  return at;
}

/// The kind of a message: its text without numbers and without names in ``.
std::string warning_kind(const std::string& message) {
  std::string kind;
  for (std::size_t at = 0; at < message.size();) {
    const char c = message[at];
    if (is_digit_at(message, at)) {
      at = end_of_number(message, at);
      continue;
    }
    kind += c;
    ++at;
    if (c != '`') continue;
    at = std::min(message.find('`', at), message.size());
    if (at < message.size()) ++at;  // skip the closing backtick
  }
  return kind;
}

/// Warnings of one kind.
struct Fold {
  const Diagnostic* first;
  int others = 0;
  std::vector<std::string> lines = {};  ///< of the others, each once
};

/// Stores the line of another warning; at most one line more than a folded warning lists.
void add_other(Fold& fold, const Diagnostic& other) {
  const std::string line = std::to_string(other.mark.line);
  ++fold.others;
  if (fold.lines.size() > kMostLines) return;
  if (std::find(fold.lines.begin(), fold.lines.end(), line) == fold.lines.end()) {
    fold.lines.push_back(line);
  }
}

std::string folded_text(const Fold& fold) {
  if (fold.others == 0) return fold.first->message;
  const std::size_t count = fold.lines.size();
  const auto shown = static_cast<std::ptrdiff_t>(std::min(count, kMostLines));
  const std::vector<std::string> lines(fold.lines.begin(), fold.lines.begin() + shown);
  return fold.first->message + " (and " + std::to_string(fold.others) + " more of this kind, in " +
         (count == 1 ? "line " : "lines ") + join(lines) + (count > kMostLines ? ", ...)" : ")");
}

}  // namespace

Diagnostics fold_warnings(const Diagnostics& diagnostics) {
  // A note without a location stands for the errors omitted from the list.
  const auto& all = diagnostics.all();
  const bool leaves_errors_out = std::any_of(all.begin(), all.end(), [](const Diagnostic& d) {
    return d.severity == Severity::kError && d.mark.file.empty();
  });
  if (leaves_errors_out) return diagnostics;
  std::vector<Fold> folds;  // each error has its own
  std::map<std::string, std::size_t> known;
  for (const Diagnostic& d : all) {
    const bool may_fold = d.severity == Severity::kWarning && d.mark.line > 0;
    if (may_fold) {
      const auto [found, is_new] =
          known.emplace(d.mark.file + '\n' + warning_kind(d.message), folds.size());
      if (!is_new) {
        add_other(folds[found->second], d);
        continue;
      }
    }
    folds.push_back({&d});
  }
  Diagnostics folded;
  for (const Fold& fold : folds) {
    if (fold.first->severity == Severity::kError) {
      folded.error(fold.first->mark, fold.first->message);
    } else {
      folded.warning(fold.first->mark, folded_text(fold));
    }
  }
  return folded;
}

}  // namespace skybody
