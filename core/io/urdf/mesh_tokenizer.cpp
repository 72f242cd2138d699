#include "core/io/urdf/mesh_tokenizer.h"

#include <cmath>

#include "core/io/files/text.h"

namespace skybody {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

}  // namespace

bool MeshTokenizer::at_line_end() const { return text_[at_] == '\n' || text_[at_] == '\r'; }

bool MeshTokenizer::pass_line_end() {
  if (at_ == text_.size() || !at_line_end()) return false;
  const bool is_pair = text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n';
  at_ += is_pair ? 2 : 1;
  ++line_;
  return true;
}

std::string_view MeshTokenizer::next_in_line() {
  for (;;) {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    if (at_ == text_.size() || text_[at_] != '\\') break;
    ++at_;
    if (pass_line_end()) continue;
    --at_;
    break;
  }
  const std::size_t begin = at_;
  while (at_ < text_.size() && !is_blank(text_[at_]) && !at_line_end()) ++at_;
  return text_.substr(begin, at_ - begin);
}

std::string_view MeshTokenizer::next() {
  std::string_view word = next_in_line();
  while (word.empty() && pass_line_end()) word = next_in_line();
  return word;
}

bool MeshTokenizer::next_line() {
  while (at_ < text_.size() && !at_line_end()) ++at_;
  return pass_line_end() && at_ < text_.size();
}

double MeshTokenizer::coordinate(std::string_view word) const {
  const std::optional<double> number = parse_number(word);
  if (number && std::isfinite(*number)) return *number;
  refuse(word.empty() ? "a number is missing" : "a number that is not finite, or none at all");
}

bool is_word(std::string_view word, std::string_view expected) {
  if (word.size() != expected.size()) return false;
  for (std::size_t k = 0; k < word.size(); ++k) {
    const char c = word[k];
    if ((c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c) != expected[k]) return false;
  }
  return true;
}

}  // namespace skybody
