// Errors and warnings about files that people write, all of them, each with its place.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/model/scenario.h"

namespace skybody {

enum class Severity { kError, kWarning };

/// One message about one place.
struct Diagnostic {
  Severity severity = Severity::kError;
  SourceLocation mark;
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
/// A message that was given before, word for word and at the same place, is not repeated. Beyond a
/// hundred errors or warnings, unless told otherwise, the rest are only counted. Messages are kept
/// as printable() makes them, the longest without their middle: whatever a file quotes in one, it
/// is valid UTF-8 and one line.
class Diagnostics {
 public:
  Diagnostics() = default;
  /// @param most  messages of each severity beyond which the rest are only counted
  explicit Diagnostics(int most) : most_(most) {}

  void error(const SourceLocation& mark, const std::string& message);
  void warning(const SourceLocation& mark, const std::string& message);

  /// Adds all messages of another list.
  void add(const Diagnostics& other);

  bool has_errors() const { return error_count_ > 0; }
  int error_count() const { return error_count_; }
  const std::vector<Diagnostic>& all() const { return list_; }

  /// Every message on its own line, in the order in which it was found.
  std::string to_string() const;

  /// Throws InputError with all messages if at least one is an error.
  void throw_if_errors() const;

 private:
  /// How many messages of one severity are in the list, and how many are not.
  struct Shown {
    int count = 0;
    int left_out = 0;
    std::size_t note = 0;  ///< where the list says how many are left out

    bool is_note(std::size_t index) const { return left_out > 0 && index == note; }
  };

  void add(Severity severity, const SourceLocation& mark, const std::string& message);
  void count_only(Shown& shown, Severity severity, int count);

  int most_ = 100;  ///< nobody mends more before the next try
  std::vector<Diagnostic> list_;
  int error_count_ = 0;
  Shown errors_;
  Shown warnings_;
};

/// `file:line:column`, without what is 0.
std::string to_string(const SourceLocation& mark);

}  // namespace skybody
