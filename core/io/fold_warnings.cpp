#include "core/io/fold_warnings.h"

#include <cctype>
#include <map>
#include <string>
#include <vector>

#include "core/io/text.h"

namespace skybody {
namespace {

constexpr std::size_t kMostLines = 5;  // that a folded warning lists

/// The message without numbers and without what stands in `` or <>.
std::string warning_kind(const std::string& message) {
  std::string kind;
  char end = 0;
  for (const char c : message) {
    if (end != 0) {
      if (c == end) end = 0;
    } else if (c == '`' || c == '<') {
      end = c == '`' ? '`' : '>';
      kind += c;
    } else if (std::isdigit(static_cast<unsigned char>(c)) == 0) {
      kind += c;
    }
  }
  return kind;
}

/// Warnings of one kind.
struct Fold {
  const Diagnostic* first;
  std::vector<std::string> lines;  ///< of the others
};

std::string folded_text(const Fold& fold) {
  const std::size_t count = fold.lines.size();
  if (count == 0) return fold.first->message;
  const auto shown = static_cast<std::ptrdiff_t>(std::min(count, kMostLines));
  const std::vector<std::string> lines(fold.lines.begin(), fold.lines.begin() + shown);
  return fold.first->message + " (and " + std::to_string(count) + " more of this kind, in " +
         (count == 1 ? "line " : "lines ") + join(lines) + (count > kMostLines ? ", ...)" : ")");
}

}  // namespace

Diagnostics fold_warnings(const Diagnostics& diagnostics) {
  std::vector<Fold> folds;  // errors each for itself
  std::map<std::string, std::size_t> known;
  for (const Diagnostic& d : diagnostics.all()) {
    const bool may_fold = d.severity == Severity::kWarning && d.mark.line > 0;
    if (may_fold) {
      const auto [found, is_new] =
          known.emplace(d.mark.file + '\n' + warning_kind(d.message), folds.size());
      if (!is_new) {
        folds[found->second].lines.push_back(std::to_string(d.mark.line));
        continue;
      }
    }
    folds.push_back({&d, {}});
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
