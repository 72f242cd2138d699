// Lists of words in messages, and suggestions for misspelt words.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace skybody {

/// `a, b, c`.
std::string join(const std::vector<std::string>& words, std::string_view separator = ", ");

/// As join() for the first 40 words, followed by the number of the others.
std::string join_first(const std::vector<std::string>& words);

/// The candidate closest to `word` by edit distance (a transposition counts one, case is ignored),
/// or empty if none is close.
std::string closest(std::string_view word, const std::vector<std::string>& candidates);

/// "; did you mean `x`?" if a candidate is close, else "; <noun>: a, b, c" (the first 40), else ""
/// without candidates. With more than 200 candidates none are compared.
std::string suggestion(std::string_view word, const std::vector<std::string>& candidates,
                       std::string_view noun = "allowed");

}  // namespace skybody
