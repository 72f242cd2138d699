// Lists of words in messages, and the word that somebody may have meant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace skybody {

/// `a, b, c`.
std::string join(const std::vector<std::string>& words, std::string_view separator = ", ");

/// The same of the first 40, and how many more there are.
std::string join_first(const std::vector<std::string>& words);

/// The candidate closest to `word` by edit distance (transpositions count one, case is ignored), or
/// empty if none is close.
std::string closest(std::string_view word, const std::vector<std::string>& candidates);

/// "; did you mean `x`?" where something is close, else "; <noun>: a, b, c" (the first 40), else
/// "". Among more than two hundred nothing is compared.
std::string suggestion(std::string_view word, const std::vector<std::string>& candidates,
                       std::string_view noun = "allowed");

}  // namespace skybody
