// Makes text from untrusted files safe to print.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace skybody {

/// The length in bytes of the UTF-8 character at the start of `text`, or 0 if there is none (also
/// for surrogates, overlong forms and an empty text).
std::size_t utf8_length(std::string_view text);

/// `text` as valid UTF-8 on one line. Invalid bytes, control characters (which could control a
/// terminal) and marks that change the writing direction become \xNN. Idempotent.
std::string printable(std::string_view text);

/// `text` with its middle omitted if it is longer than `limit` bytes. Characters stay whole.
std::string shortened(const std::string& text, std::size_t limit);

}  // namespace skybody
