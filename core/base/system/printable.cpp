#include "core/base/system/printable.h"

#include <array>

namespace skybody {
namespace {

unsigned byte_at(std::string_view text, std::size_t i) {
  return static_cast<unsigned char>(text[i]);
}

bool is_continuation(unsigned byte) { return (byte & 0xc0u) == 0x80u; }

/// Number of bytes of a character whose first byte is `first`; 0: not a first byte.
std::size_t length_by_first_byte(unsigned first) {
  if (first < 0x80) return 1;
  if (first >= 0xc2 && first <= 0xdf) return 2;
  if (first >= 0xe0 && first <= 0xef) return 3;
  return first >= 0xf0 && first <= 0xf4 ? 4 : 0;
}

/// Whether the second byte makes a three- or four-byte character overlong, a surrogate or too large
/// (the table of well-formed sequences in the Unicode standard, section 3.9).
bool is_ill_formed(unsigned first, unsigned second) {
  return (first == 0xe0 && second < 0xa0) || (first == 0xed && second > 0x9f) ||
         (first == 0xf0 && second < 0x90) || (first == 0xf4 && second > 0x8f);
}

unsigned code_point(std::string_view character) {
  constexpr std::array<unsigned, 5> kFirstBits = {0, 0x7f, 0x1f, 0x0f, 0x07};
  unsigned code = byte_at(character, 0) & kFirstBits[character.size()];
  for (std::size_t i = 1; i < character.size(); ++i) {
    code = (code << 6) | (byte_at(character, i) & 0x3fu);
  }
  return code;
}

/// Control characters (C0, delete, C1), line and paragraph separators, and marks of direction.
bool is_unsafe(unsigned code) {
  return code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x200e || code == 0x200f ||
         (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
}

void append_escaped(std::string& out, std::string_view bytes) {
  constexpr const char* kDigits = "0123456789abcdef";
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const unsigned byte = byte_at(bytes, i);
    out += {'\\', 'x', kDigits[byte >> 4], kDigits[byte & 15u]};
  }
}

}  // namespace

std::size_t utf8_length(std::string_view text) {
  if (text.empty()) return 0;
  const unsigned first = byte_at(text, 0);
  const std::size_t length = length_by_first_byte(first);
  if (length == 0 || length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if (!is_continuation(byte_at(text, i))) return 0;
  }
  return length > 2 && is_ill_formed(first, byte_at(text, 1)) ? 0 : length;
}

std::string printable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const std::string_view character = text.substr(0, length == 0 ? 1 : length);
    if (length == 0 || is_unsafe(code_point(character))) {
      append_escaped(out, character);
    } else {
      out += character;
    }
    text.remove_prefix(character.size());
  }
  return out;
}

std::string shortened(const std::string& text, std::size_t limit) {
  if (text.size() <= limit) return text;
  std::size_t begin = limit / 2, end = text.size() - limit / 2;
  while (begin > 0 && is_continuation(byte_at(text, begin))) --begin;
  while (end < text.size() && is_continuation(byte_at(text, end))) ++end;
  return text.substr(0, begin) + " ... " + text.substr(end);
}

}  // namespace skybody
