// Errors and warnings about files that people write, all of them, each with its place.
#pragma once

#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/model/scenario.h"

namespace skybody {

enum class Severity { kError, kWarning };

/// One message about one place.
struct Diagnostic {
  Severity severity = Severity::kError;
  SourceMark mark;
  std::string message;  ///< what is wrong with the value, what is allowed, what helps; one line

  /// `file:line:column: error: message`. Column and line are left out where they are 0.
  std::string to_string() const;
};

/// Input that cannot be used. what() holds every error, one a line.
class InputError : public Error {
 public:
  explicit InputError(std::vector<Diagnostic> list);

  /// All errors and warnings, in the order in which they were found.
  const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

 private:
  std::vector<Diagnostic> diagnostics_;
};

/// Collects messages while files are read, so that a user sees all of them at once.
/// A message that was given before, word for word and at the same place, is not repeated.
class Diagnostics {
 public:
  void error(const SourceMark& mark, std::string message);
  void warning(const SourceMark& mark, std::string message);

  bool has_errors() const { return error_count_ > 0; }
  int error_count() const { return error_count_; }
  const std::vector<Diagnostic>& all() const { return list_; }

  /// Every message on its own line, in the order in which it was found.
  std::string to_string() const;

  /// Throws InputError with all messages if at least one is an error.
  void throw_if_errors() const;

 private:
  void add(Severity severity, const SourceMark& mark, std::string message);

  std::vector<Diagnostic> list_;
  int error_count_ = 0;
};

/// `file:line:column`, without what is 0.
std::string to_string(const SourceMark& mark);

}  // namespace skybody
