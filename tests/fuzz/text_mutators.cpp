#include <algorithm>
#include <array>
#include <cctype>
#include <functional>

#include "tests/fuzz/mutator.h"

namespace skybody::fuzz {
namespace {

/// A part of a text.
struct Span {
  std::size_t at, size;
};

/// Numbers that readers and physics may not handle.
constexpr std::array kNumbers = {"0",
                                 "-1",
                                 "1e300",
                                 "-1e300",
                                 "5e-324",
                                 "nan",
                                 ".nan",
                                 "inf",
                                 ".inf",
                                 "-.inf",
                                 "1e-30",
                                 "1e200",
                                 "1e150",
                                 "1e19",
                                 "0x10",
                                 "1_000",
                                 "1e999",
                                 "-0.0",
                                 "+5",
                                 "1.5",
                                 "1e6",
                                 "1000000",
                                 "0.1",
                                 "12345678901234567890",
                                 "1e-6",
                                 "1e-320",
                                 "1,5",
                                 "08",
                                 "1e",
                                 "2e9",
                                 "1000",
                                 "-0.001",
                                 "9223372036854775808",
                                 "18446744073709551616"};

/// Values of a wrong type.
constexpr std::array kValues = {"{}",     "[]",      "null",      "~",        "true",      "\"\"",
                                "[[[]]]", "{a: {}}", "!!str",     "x",        "[0, 0, 0]", "|\n  x",
                                "*x",     "&x 1",    "\"\\x00\"", "\"\xff\"", "&amp;",     "a\nb"};

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool is_number(char c) { return is_word(c) || c == '.' || c == '-' || c == '+'; }
bool begins_number(const std::string& text, std::size_t at) {
  const auto digit = [&](std::size_t k) {
    return k < text.size() && std::isdigit(static_cast<unsigned char>(text[k])) != 0;
  };
  if (at > 0 && is_number(text[at - 1])) return false;
  return digit(at) || ((text[at] == '-' || text[at] == '.') && digit(at + 1));
}

/// Pieces of the text: each begins where `begins` is true and extends while `goes_on` is true.
template <class Begins, class GoesOn>
std::vector<Span> pieces(const std::string& text, Begins begins, GoesOn goes_on) {
  std::vector<Span> found;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (!begins(text, at)) continue;
    std::size_t end = at + 1;
    while (end < text.size() && goes_on(text[end])) ++end;
    found.push_back({at, end - at});
    at = end - 1;
  }
  return found;
}

std::vector<Span> numbers(const std::string& text) {
  return pieces(text, begins_number, is_number);
}

std::vector<Span> words(const std::string& text) {
  const auto begins = [](const std::string& t, std::size_t at) {
    return std::isalpha(static_cast<unsigned char>(t[at])) != 0 || t[at] == '_';
  };
  return pieces(text, begins, is_word);
}

/// Text between quotes, or from ": " to the end of the value.
std::vector<Span> values(const std::string& text) {
  std::vector<Span> found;
  for (std::size_t at = 0; at + 1 < text.size(); ++at) {
    std::size_t end = std::string::npos;
    if (text[at] == '"') end = text.find('"', at + 1);
    if (text[at] == ':' && text[at + 1] == ' ') end = text.find_first_of(",}\n", ++at);
    if (end == std::string::npos) continue;
    found.push_back({at + 1, end - at - 1});
    at = end;
  }
  return found;
}

std::vector<Span> lines(const std::string& text) {
  std::vector<Span> found;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size() - 1);
    found.push_back({at, end + 1 - at});
    at = end + 1;
  }
  return found;
}

/// Replaces a random piece, if there are any.
void replace_one(std::string& input, Dice& dice, const std::vector<Span>& found,
                 const std::string& by) {
  if (found.empty()) return;
  const Span piece = dice.pick(found);
  input.replace(piece.at, piece.size, by);
}

void number_by_special(std::string& input, Dice& dice, const Material&) {
  replace_one(input, dice, numbers(input), dice.pick(kNumbers));
}

/// Replaces a number by a close one, which may be slightly out of bounds.
void number_by_neighbour(std::string& input, Dice& dice, const Material&) {
  constexpr std::array kFactors = {"e1", "e-1", "e5", "e-5", "0", "9", "e12", "e-12"};
  const std::vector<Span> found = numbers(input);
  if (found.empty()) return;
  const Span piece = dice.pick(found);
  input.insert(piece.at + piece.size, dice.pick(kFactors));
}

void word_by_word(std::string& input, Dice& dice, const Material& material) {
  if (material.words.empty()) return;
  replace_one(input, dice, words(input), dice.pick(material.words));
}

void rename_word(std::string& input, Dice& dice, const Material&) {
  const std::vector<Span> found = words(input);
  if (found.empty()) return;
  const Span piece = dice.pick(found);
  const std::size_t at = piece.at + dice.below(piece.size);
  dice.one_in(2) ? input.insert(at, 1, input[at]) : input.erase(at, 1);
}

void value_by_other_type(std::string& input, Dice& dice, const Material&) {
  replace_one(input, dice, values(input), dice.pick(kValues));
}

void value_by_word(std::string& input, Dice& dice, const Material& material) {
  if (material.words.empty()) return;
  replace_one(input, dice, values(input), dice.pick(material.words));
}

void swap_values(std::string& input, Dice& dice, const Material&) {
  const std::vector<Span> found = values(input);
  if (found.size() < 2) return;
  const Span from = dice.pick(found);
  const std::string value = input.substr(from.at, from.size);
  replace_one(input, dice, found, value);
}

void nest_value(std::string& input, Dice& dice, const Material&) {
  const std::vector<Span> found = values(input);
  if (found.empty()) return;
  const std::size_t depth = dice.length(2000);
  const bool map = dice.one_in(2);
  std::string before, after;
  for (std::size_t k = 0; k < depth; ++k) {
    before += map ? "{a: " : "[";
    after += map ? '}' : ']';
  }
  const Span piece = dice.pick(found);
  input.insert(piece.at + piece.size, after);
  input.insert(piece.at, before);
}

void delete_line(std::string& input, Dice& dice, const Material&) {
  replace_one(input, dice, lines(input), "");
}

/// Repeats a line or a block of lines, once or many times.
void repeat_lines(std::string& input, Dice& dice, const Material&) {
  const std::vector<Span> found = lines(input);
  if (found.empty()) return;
  const std::size_t first = dice.below(found.size());
  const std::size_t last = std::min(found.size() - 1, first + dice.length(8) - 1);
  const std::string block =
      input.substr(found[first].at, found[last].at + found[last].size - found[first].at);
  const std::size_t most = std::max<std::size_t>(1, kMostBytes / 8 / block.size());
  std::string more;
  for (std::size_t k = dice.length(most); k > 0; --k) more += block;
  input.insert(found[first].at, more);
}

void swap_lines(std::string& input, Dice& dice, const Material&) {
  const std::vector<Span> found = lines(input);
  if (found.empty()) return;
  Span a = dice.pick(found), b = dice.pick(found);
  if (a.at > b.at) std::swap(a, b);
  if (a.at == b.at) return;
  const std::string first = input.substr(a.at, a.size), second = input.substr(b.at, b.size);
  input.replace(b.at, b.size, first);
  input.replace(a.at, a.size, second);
}

void indent_line(std::string& input, Dice& dice, const Material&) {
  const std::vector<Span> found = lines(input);
  if (found.empty()) return;
  const Span line = dice.pick(found);
  if (dice.one_in(3) && input[line.at] == ' ') {
    input.erase(line.at, 1);
  } else {
    input.insert(line.at, dice.one_in(8) ? "\t" : "  ");
  }
}

/// Inserts a line of a valid input.
void insert_line(std::string& input, Dice& dice, const Material& material) {
  const std::string& other = dice.pick(material.seeds);
  const std::vector<Span> theirs = lines(other), ours = lines(input);
  if (theirs.empty()) return;
  const Span line = dice.pick(theirs);
  input.insert(ours.empty() ? 0 : dice.pick(ours).at, other, line.at, line.size);
}

constexpr Mutator kMutators[] = {
    {"a special number", number_by_special},
    {"a neighbouring number", number_by_neighbour},
    {"another word", word_by_word},
    {"a misspelt word", rename_word},
    {"a value of another type", value_by_other_type},
    {"another value", value_by_word},
    {"swap values", swap_values},
    {"nest a value", nest_value},
    {"delete a line", delete_line},
    {"repeat lines", repeat_lines},
    {"swap lines", swap_lines},
    {"indent a line", indent_line},
    {"insert a line", insert_line},
};

}  // namespace

std::span<const Mutator> text_mutators() { return kMutators; }

}  // namespace skybody::fuzz
