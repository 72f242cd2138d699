#include "tests/fuzz/mutator.h"

#include <algorithm>

namespace skybody::fuzz {

std::string make_input(Dice& dice, const Material& material,
                       std::span<const std::span<const Mutator>> tables) {
  std::string input = dice.pick(material.seeds);
  const std::size_t most = std::max(kMostBytes, input.size() + input.size() / 2);
  const std::size_t changes = dice.length(8);  // mostly one or two: such inputs get further
  for (std::size_t k = 0; k < changes; ++k) {
    dice.pick(dice.pick(tables)).apply(input, dice, material);
    if (input.size() > most) input.resize(most);
  }
  return input;
}

}  // namespace skybody::fuzz
