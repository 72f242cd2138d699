// Small helpers on text for readers and their messages.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skybody {

/// The number that the whole of `text` spells, or nothing. Independent of the locale, correctly
/// rounded; accepts a leading '+' and YAML's .inf and .nan.
std::optional<double> parse_number(std::string_view text);

/// The shortest decimal text that reads back as the same double (integers below 10^7 without an
/// exponent, -0 as 0).
std::string format_number(double value);

/// `[1, 2, 3]`.
std::string format_numbers(const std::vector<double>& values);

/// `a, b, c`.
std::string join(const std::vector<std::string>& words, std::string_view separator = ", ");

/// The candidate closest to `word` by edit distance (transpositions count one, case is ignored), or
/// empty if none is close.
std::string closest(std::string_view word, const std::vector<std::string>& candidates);

/// "; did you mean `x`?" where something is close, else "; <noun>: a, b, c" (the first 40), else
/// "". Among more than two hundred nothing is compared.
std::string suggestion(std::string_view word, const std::vector<std::string>& candidates,
                       std::string_view noun = "allowed");

/// Whether `text` can be part of a dotted path: letters, digits, '_' and '-', not starting with a
/// digit or '-'.
bool is_identifier(std::string_view text);

/// The words of `text`, split at white space.
std::vector<std::string> split_words(std::string_view text);

}  // namespace skybody
