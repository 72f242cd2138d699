#include "core/io/yaml/diagnostics.h"

#include <utility>

#include "core/base/system/printable.h"

namespace skybody {
namespace {

constexpr std::size_t kLongestMessage = 2000;  // [bytes]; longer than lists of names in messages
constexpr std::size_t kLongestPlace = 500;     // [bytes] of a file's name or an override

bool is_same(const Diagnostic& a, const Diagnostic& b) {
  return a.mark.line == b.mark.line && a.mark.column == b.mark.column && a.severity == b.severity &&
         a.message == b.message && a.mark.file == b.mark.file;
}

std::string more_text(int count, Severity severity) {
  const char* kind = severity == Severity::kError ? "error" : "warning";
  return std::to_string(count) + " more " + kind + (count == 1 ? " is" : "s are") + " not shown";
}

std::string joined_errors(const std::vector<Diagnostic>& list) {
  std::string text;
  for (const Diagnostic& diagnostic : list) {
    if (diagnostic.severity != Severity::kError) continue;
    if (!text.empty()) text += '\n';
    text += diagnostic.to_string();
  }
  return text;
}

}  // namespace

std::string Diagnostic::to_string() const {
  const char* kind = severity == Severity::kError ? "error: " : "warning: ";
  const std::string place = skybody::to_string(mark);
  return (place.empty() ? std::string() : place + ": ") + kind + message;
}

InputError::InputError(std::vector<Diagnostic> list)
    : Error(joined_errors(list)), diagnostics_(std::move(list)) {}

void Diagnostics::add(Severity severity, const SourceLocation& mark, const std::string& message) {
  Diagnostic added{severity, mark, shortened(printable(message), kLongestMessage)};
  added.mark.file = shortened(printable(mark.file), kLongestPlace);
  for (const Diagnostic& known : list_) {
    if (is_same(known, added)) return;
  }
  if (severity == Severity::kError) ++error_count_;
  Shown& shown = severity == Severity::kError ? errors_ : warnings_;
  if (shown.count < most_) {
    ++shown.count;
    list_.push_back(std::move(added));
  } else {
    count_only(shown, severity, 1);
  }
}

void Diagnostics::count_only(Shown& shown, Severity severity, int count) {
  if (count == 0) return;
  if (shown.left_out == 0) {
    shown.note = list_.size();
    list_.emplace_back().severity = severity;
  }
  shown.left_out += count;
  list_[shown.note].message = more_text(shown.left_out, severity);
}

void Diagnostics::add(const Diagnostics& other) {
  for (std::size_t i = 0; i < other.list_.size(); ++i) {
    if (other.errors_.is_note(i) || other.warnings_.is_note(i)) continue;
    add(other.list_[i].severity, other.list_[i].mark, other.list_[i].message);
  }
  error_count_ += other.errors_.left_out;
  count_only(errors_, Severity::kError, other.errors_.left_out);
  count_only(warnings_, Severity::kWarning, other.warnings_.left_out);
}

void Diagnostics::error(const SourceLocation& mark, const std::string& message) {
  add(Severity::kError, mark, message);
}

void Diagnostics::warning(const SourceLocation& mark, const std::string& message) {
  add(Severity::kWarning, mark, message);
}

std::string Diagnostics::to_string() const {
  std::string text;
  for (const Diagnostic& diagnostic : list_) text += diagnostic.to_string() + '\n';
  return text;
}

void Diagnostics::throw_if_errors() const {
  if (has_errors()) throw InputError(list_);
}

}  // namespace skybody
