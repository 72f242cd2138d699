#include "learn/network/noise.h"

#include <algorithm>

#include "learn/network/kernels/kernels.h"

namespace skybody::learn {
namespace {

constexpr std::size_t kWords = 64;        // at a time, of 64 bits: a radius and an angle
constexpr std::size_t kGroup = 2 * kPad;  // normals of 16 words

}  // namespace

void draw_normals(const NoiseCounter& counter, std::span<float> values, Isa isa) {
  const KernelTable& kernels = kernels_of(isa);
  Random<double> random(counter.key, counter.episode, counter.step, counter.stream);
  std::uint32_t radius[kWords], angle[kWords];
  float normals[2 * kWords];
  for (std::size_t done = 0; done < values.size(); done += 2 * kWords) {
    const std::size_t wanted = std::min(2 * kWords, values.size() - done);
    const std::size_t words = (wanted + kGroup - 1) / kGroup * kPad;
    for (std::size_t i = 0; i < words; ++i) {
      const std::uint64_t word = random.bits();
      radius[i] = static_cast<std::uint32_t>(word >> 32);
      angle[i] = static_cast<std::uint32_t>(word);
    }
    kernels.normals(radius, angle, normals, words);
    std::copy_n(normals, wanted, values.data() + done);
  }
}

}  // namespace skybody::learn
