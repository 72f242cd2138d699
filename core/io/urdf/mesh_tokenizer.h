// Splits a mesh's text into words, line by line. Internal to core/io.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>

#include "core/io/urdf/mesh_format.h"

namespace skybody {

/// Reads a text once. Lines end with "\n", "\r\n" or "\r"; a "\" at the end of a line continues it
/// on the next (OBJ).
class MeshTokenizer {
 public:
  /// @param line  number of the first line
  explicit MeshTokenizer(std::string_view text, int line = 1) : text_(text), line_(line) {}

  /// The next word, on this line or a later one; empty at the end of the text.
  std::string_view next();
  /// The next word of this line; empty at its end.
  std::string_view next_in_line();
  /// Goes to the next line; false at the end of the text.
  bool next_line();

  /// The next word on any line, as a finite number. @throws MeshError
  double coordinate() { return coordinate(next()); }
  /// A word as a finite number. @throws MeshError
  double coordinate(std::string_view word) const;

  int line() const { return line_; }
  /// Number of bytes read.
  std::size_t place() const { return at_; }
  [[noreturn]] void refuse(const std::string& reason) const { throw MeshError(line_, reason); }

 private:
  bool at_line_end() const;
  /// Skips the end of a line, if there is one here.
  bool pass_line_end();

  std::string_view text_;
  std::size_t at_ = 0;
  int line_;
};

/// Whether `word` equals `expected` (lower case), ignoring case.
bool is_word(std::string_view word, std::string_view expected);

/// The whole of `word` as an integer, or nullopt if it is not a number within Integer's range.
template <class Integer>
std::optional<Integer> parse_integer(std::string_view word) {
  Integer number{};
  const char* const end = word.data() + word.size();
  const auto result = std::from_chars(word.data(), end, number);
  if (word.empty() || result.ptr != end || result.ec != std::errc()) return std::nullopt;
  return number;
}

}  // namespace skybody
