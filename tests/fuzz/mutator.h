// Small changes that turn a valid input into a bad one.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tests/fuzz/dice.h"

namespace skybody::fuzz {

/// Material from which mutators take pieces.
struct Material {
  std::vector<std::string> seeds;  ///< valid inputs, at least one
  std::vector<std::string> words;  ///< vocabulary of the input's language: keys, values, names
};

/// One kind of change. To add one, write a function and add a row to the table of its file.
struct Mutator {
  const char* name;
  void (*apply)(std::string& input, Dice& dice, const Material& material);
};

/// For any input: bits, bytes and chunks.
std::span<const Mutator> byte_mutators();
/// For text: numbers, words, quoted values, lines.
std::span<const Mutator> text_mutators();

/// Longer inputs are cut, unless their seed is as long, so that the time goes into the reader and
/// not into the mutators.
inline constexpr std::size_t kMostBytes = 1 << 18;

/// A seed with one or several changes.
/// @param tables  tables of mutators; each table is chosen with equal probability
std::string make_input(Dice& dice, const Material& material,
                       std::span<const std::span<const Mutator>> tables);

}  // namespace skybody::fuzz
