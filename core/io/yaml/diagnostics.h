// Errors and warnings about input files, collected with their locations.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/base/system/error.h"
#include "core/model/scenario.h"

namespace skybody {

enum class Severity { kError, kWarning };

/// One message with its location.
struct Diagnostic {
  Severity severity = Severity::kError;
  SourceLocation mark;
  std::string message;  ///< the problem, the allowed values and the remedy; one line

  /// `file:line:column: error: message`. A column or line of 0 is omitted.
  std::string to_string() const;
};

/// Invalid input. what() contains all errors, one per line.
class InputError : public Error {
 public:
  explicit InputError(std::vector<Diagnostic> list);

  /// All errors and warnings, in the order of their detection.
  const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

 private:
  std::vector<Diagnostic> diagnostics_;
};

/// Collects messages while files are read, so that the user gets all of them at once.
/// - A repeated message (same text, same location) is dropped.
/// - Beyond `most` errors or warnings (default 100) the others are only counted.
/// - Messages are made printable(), and long ones lose their middle: quoted text of files is always
///   valid UTF-8 on one line.
class Diagnostics {
 public:
  Diagnostics() = default;
  /// @param most  number of messages of each severity that are kept; the others are only counted
  explicit Diagnostics(int most) : most_(most) {}

  void error(const SourceLocation& mark, const std::string& message);
  void warning(const SourceLocation& mark, const std::string& message);

  /// Adds all messages of another list.
  void add(const Diagnostics& other);

  bool has_errors() const { return error_count_ > 0; }
  int error_count() const { return error_count_; }
  const std::vector<Diagnostic>& all() const { return list_; }

  /// Every message on its own line, in the order of detection.
  std::string to_string() const;

  /// Throws InputError with all messages if at least one is an error.
  void throw_if_errors() const;

 private:
  /// Numbers of messages of one severity in the list and left out of it.
  struct Shown {
    int count = 0;
    int left_out = 0;
    std::size_t note = 0;  ///< index of the note with the number of omitted messages

    bool is_note(std::size_t index) const { return left_out > 0 && index == note; }
  };

  void add(Severity severity, const SourceLocation& mark, const std::string& message);
  void count_only(Shown& shown, Severity severity, int count);

  int most_ = 100;  ///< users do not fix more at a time
  std::vector<Diagnostic> list_;
  int error_count_ = 0;
  Shown errors_;
  Shown warnings_;
};

}  // namespace skybody
