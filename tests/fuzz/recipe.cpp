#include "tests/fuzz/recipe.h"

#include <sstream>

namespace skybody::fuzz {
namespace {

void replace_all(std::string& text, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size()) {
    text.replace(at, what.size(), by);
  }
}

}  // namespace

std::string expand_recipe(const std::string& recipe) {
  std::istringstream lines(recipe);
  std::string input;
  long count = 0;
  for (std::string text; lines >> count && lines.get() && std::getline(lines, text);) {
    replace_all(text, "\\n", "\n");
    for (long k = 0; k < count; ++k) {
      std::string piece = text;
      replace_all(piece, "{k}", std::to_string(k));
      replace_all(piece, "{k-1}", std::to_string(k - 1));
      replace_all(piece, "{k+1}", std::to_string(k + 1));
      input += piece;
    }
  }
  return input;
}

}  // namespace skybody::fuzz
