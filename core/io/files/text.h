// Text helpers for readers and their messages.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/system/suggestion.h"  // IWYU pragma: export

namespace skybody {

/// Parses the whole of `text` as a number; nullopt if it is none. Independent of the locale,
/// correctly rounded; accepts a leading '+' and YAML's .inf and .nan.
std::optional<double> parse_number(std::string_view text);

/// The shortest decimal text that parses to the same double (integers below 10^7 without an
/// exponent, -0 as 0).
std::string format_number(double value);

/// `[1, 2, 3]`.
std::string format_numbers(const std::vector<double>& values);

/// Whether `text` can be part of a dotted path: letters, digits, '_' and '-', not starting with a
/// digit or '-'.
bool is_identifier(std::string_view text);

/// The words of `text`, split at white space.
std::vector<std::string> split_words(std::string_view text);

}  // namespace skybody
