#include "core/io/diagnostics.h"

#include <utility>

namespace skybody {
namespace {

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

std::string to_string(const SourceMark& mark) {
  std::string text = mark.file;
  if (mark.line > 0) text += ':' + std::to_string(mark.line);
  if (mark.line > 0 && mark.column > 0) text += ':' + std::to_string(mark.column);
  return text;
}

std::string Diagnostic::to_string() const {
  const char* kind = severity == Severity::kError ? "error: " : "warning: ";
  const std::string place = skybody::to_string(mark);
  return (place.empty() ? std::string() : place + ": ") + kind + message;
}

InputError::InputError(std::vector<Diagnostic> list)
    : Error(joined_errors(list)), diagnostics_(std::move(list)) {}

void Diagnostics::add(Severity severity, const SourceMark& mark, std::string message) {
  for (const Diagnostic& known : list_) {
    const bool same_place = known.mark.file == mark.file && known.mark.line == mark.line &&
                            known.mark.column == mark.column;
    if (same_place && known.severity == severity && known.message == message) return;
  }
  list_.push_back({severity, mark, std::move(message)});
  if (severity == Severity::kError) ++error_count_;
}

void Diagnostics::error(const SourceMark& mark, std::string message) {
  add(Severity::kError, mark, std::move(message));
}

void Diagnostics::warning(const SourceMark& mark, std::string message) {
  add(Severity::kWarning, mark, std::move(message));
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
