#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "tests/fuzz/mutator.h"

namespace skybody::fuzz {
namespace {

/// Offset and length of a chunk of an input.
struct Chunk {
  std::size_t at, size;
};

Chunk chunk_of(const std::string& input, Dice& dice) {
  if (input.empty()) return {0, 0};
  const std::size_t size = dice.length(input.size());
  return {dice.below(input.size() - size + 1), size};
}

std::size_t gap_of(const std::string& input, Dice& dice) { return dice.below(input.size() + 1); }

/// Index of a byte; half of the draws are near the beginning or the end, where binary formats have
/// their tables.
std::size_t byte_of(const std::string& input, Dice& dice) {
  constexpr std::size_t kHeader = 1024;
  const std::size_t near = std::min(input.size(), kHeader);
  switch (dice.below(4)) {
    case 0:
      return dice.below(near);
    case 1:
      return input.size() - 1 - dice.below(near);
    default:
      return dice.below(input.size());
  }
}

void flip_bit(std::string& input, Dice& dice, const Material&) {
  if (input.empty()) return;
  const std::size_t at = byte_of(input, dice);
  input[at] = static_cast<char>(input[at] ^ (1 << dice.below(8)));
}

void set_byte(std::string& input, Dice& dice, const Material&) {
  constexpr std::array<unsigned char, 10> kBytes = {0,    1,    0x7f, 0x80, 0xff,
                                                    0xc3, 0xe2, '\n', '\r', 0x1b};
  if (input.empty()) return;
  const auto byte = dice.one_in(2) ? dice.pick(kBytes) : static_cast<unsigned char>(dice.bits());
  input[byte_of(input, dice)] = static_cast<char>(byte);
}

/// Overwrites 2, 4 or 8 bytes with an integer that is unlikely as a length or an offset.
void set_integer(std::string& input, Dice& dice, const Material&) {
  constexpr std::array<std::uint64_t, 9> kNumbers = {
      0, 1, ~0ull, 1ull << 31, (1ull << 31) - 1, 1ull << 61, 1ull << 63, 0xfffffffeu, 1ull << 32};
  const std::size_t size = std::size_t{2} << dice.below(3);
  if (input.size() < size) return;
  std::uint64_t number = dice.pick(kNumbers);
  if (dice.one_in(3)) number = input.size() + dice.below(16) - 8;
  std::memcpy(input.data() + std::min(byte_of(input, dice), input.size() - size), &number, size);
}

/// Overwrites 4 or 8 bytes with a float or a double.
void set_real(std::string& input, Dice& dice, const Material&) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr std::array<double, 10> kNumbers = {
      0.0,   -0.0,  5e-324,    1e300,     -1e300, std::numeric_limits<double>::quiet_NaN(),
      1e-30, 1e150, kInfinity, -kInfinity};
  const double number = dice.pick(kNumbers);
  const auto single = static_cast<float>(number);
  const bool is_single = dice.one_in(2);
  const std::size_t size = is_single ? sizeof single : sizeof number;
  if (input.size() < size) return;
  const std::size_t at = dice.below(input.size() / size) * size;
  std::memcpy(input.data() + at,
              is_single ? static_cast<const void*>(&single) : static_cast<const void*>(&number),
              size);
}

void fill_chunk(std::string& input, Dice& dice, const Material&) {
  const Chunk chunk = chunk_of(input, dice);
  const char byte = dice.one_in(3) ? static_cast<char>(dice.bits()) : '\0';
  std::fill_n(input.begin() + static_cast<std::ptrdiff_t>(chunk.at), chunk.size, byte);
}

void truncate(std::string& input, Dice& dice, const Material&) {
  input.resize(gap_of(input, dice));
}

void extend(std::string& input, Dice& dice, const Material&) {
  const std::size_t more = dice.length(4096);
  for (std::size_t k = 0; k < more; ++k) input.push_back(static_cast<char>(dice.bits()));
}

void delete_chunk(std::string& input, Dice& dice, const Material&) {
  const Chunk chunk = chunk_of(input, dice);
  input.erase(chunk.at, chunk.size);
}

void duplicate_chunk(std::string& input, Dice& dice, const Material&) {
  const Chunk chunk = chunk_of(input, dice);
  input.insert(gap_of(input, dice), input.substr(chunk.at, chunk.size));
}

void swap_chunks(std::string& input, Dice& dice, const Material&) {
  const Chunk a = chunk_of(input, dice), b = chunk_of(input, dice);
  const std::size_t size = std::min(a.size, b.size);
  const std::string first = input.substr(a.at, size), second = input.substr(b.at, size);
  input.replace(b.at, size, first);
  input.replace(a.at, size, second);
}

/// Inserts a chunk of a valid input, either the same input or another one.
void splice(std::string& input, Dice& dice, const Material& material) {
  const std::string& other = dice.pick(material.seeds);
  const Chunk from = chunk_of(other, dice), to = chunk_of(input, dice);
  input.replace(to.at, dice.one_in(2) ? to.size : 0, other, from.at, from.size);
}

void insert_word(std::string& input, Dice& dice, const Material& material) {
  if (material.words.empty()) return flip_bit(input, dice, material);
  input.insert(gap_of(input, dice), dice.pick(material.words));
}

constexpr Mutator kMutators[] = {
    {"flip a bit", flip_bit},
    {"set a byte", set_byte},
    {"set an integer", set_integer},
    {"set a real", set_real},
    {"fill a chunk", fill_chunk},
    {"truncate", truncate},
    {"extend", extend},
    {"delete a chunk", delete_chunk},
    {"duplicate a chunk", duplicate_chunk},
    {"swap chunks", swap_chunks},
    {"splice", splice},
    {"insert a word", insert_word},
};

}  // namespace

std::span<const Mutator> byte_mutators() { return kMutators; }

}  // namespace skybody::fuzz
