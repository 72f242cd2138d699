// Large inputs in a few lines, so that the corpus stays small.
//
// Each line of a recipe is `COUNT TEXT`: the text COUNT times. In it `\n` is a line's end, `{k}`
// the number of the repetition from 0, `{k-1}` the one before and `{k+1}` the one behind.
#pragma once

#include <string>

namespace skybody::fuzz {

std::string expand_recipe(const std::string& recipe);

}  // namespace skybody::fuzz
