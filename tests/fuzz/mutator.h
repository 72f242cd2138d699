// Small changes that make a bad input of a good one.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tests/fuzz/dice.h"

namespace skybody::fuzz {

/// What mutators take pieces from.
struct Material {
  std::vector<std::string> seeds;  ///< valid inputs, at least one
  std::vector<std::string> words;  ///< what the input's language has: keys, values, names
};

/// One kind of change. New ones are a function and a row in the table of their file.
struct Mutator {
  const char* name;
  void (*apply)(std::string& input, Dice& dice, const Material& material);
};

/// For any input: bits, bytes and chunks.
std::span<const Mutator> byte_mutators();
/// For text: numbers, words, quoted values, lines.
std::span<const Mutator> text_mutators();

/// Longer inputs are cut, unless their seed is as long: an input's time is to be the reader's, not
/// the mutators'.
inline constexpr std::size_t kMostBytes = 1 << 18;

/// A seed with one or several changes.
/// @param tables  of mutators; each is chosen equally often
std::string make_input(Dice& dice, const Material& material,
                       std::span<const std::span<const Mutator>> tables);

}  // namespace skybody::fuzz
