// Large inputs in a few lines, so that the corpus stays small.
//
// Each line of a recipe is `COUNT TEXT` and expands to COUNT copies of the text. In it `\n` is a
// line feed, `{k}` is the number of the copy from 0, `{k-1}` the previous and `{k+1}` the next
// number.
#pragma once

#include <string>

namespace skybody::fuzz {

std::string expand_recipe(const std::string& recipe);

}  // namespace skybody::fuzz
