// Text from files of strangers, made safe to print.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace skybody {

/// The length in bytes of the UTF-8 character that `text` begins with, or 0 where it begins with
/// none (also for surrogates, overlong forms and an empty text).
std::size_t utf8_length(std::string_view text);

/// `text` as valid UTF-8 that fits into one line: bytes that are no UTF-8, control characters
/// (which could drive a terminal) and marks that turn the direction of writing become \xNN.
/// Printing twice changes nothing.
std::string printable(std::string_view text);

/// `text` with its middle left out where it is longer than `limit` bytes. Characters stay whole.
std::string shortened(const std::string& text, std::size_t limit);

}  // namespace skybody
