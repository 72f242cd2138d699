// One line on stderr with the progress of a flight; no output if stderr is not a terminal.
#pragma once

#include <chrono>
#include <string>

namespace skybody {

class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine() { clear(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Whether the line may be updated: on a terminal, at most ten times a second.
  bool is_due();
  void show(const std::string& text);
  void clear();

 private:
  bool terminal_;
  bool shown_ = false;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace skybody
