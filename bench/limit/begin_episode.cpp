#include "bench/limit/hover_block.h"

namespace skybody::bench::limit {
namespace {

/// Sebastiano Vigna's splitmix64 (public domain): the next of a sequence that starts anywhere.
class Draws {
 public:
  explicit Draws(std::uint64_t start) : state_(start) {}
  double uniform(double low, double high) {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return low + (high - low) * (static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53);
  }

 private:
  std::uint64_t state_;
};

}  // namespace

[[gnu::noinline]] void begin_episode(double* values, int stride, std::uint64_t environment,
                                     std::uint64_t episode) {
  const auto at = [&](int k) -> double& { return values[k * stride]; };
  Draws draw(environment * 0x632be59bd9b4e019u + episode);
  at(kPosition) = draw.uniform(-5.0, 5.0);
  at(kPosition + 1) = draw.uniform(-5.0, 5.0);
  at(kPosition + 2) = draw.uniform(0.3, 3.0);
  const double half = 0.5 * draw.uniform(-0.72, 0.72);
  at(kRotation) = cos(half);
  at(kRotation + 1) = at(kRotation + 2) = 0.0;
  at(kRotation + 3) = sin(half);
  for (int k = 0; k < 3; ++k) at(kVelocity + k) = at(kSpin + k) = 0.0;
  // Carries kMass with four rotors.
  for (int k = 0; k < 4; ++k) at(kRotor + k) = sqrt(kMass * kGravity / (4.0 * kThrust));
  at(kTarget) = draw.uniform(-5.0, 5.0);
  at(kTarget + 1) = draw.uniform(-5.0, 5.0);
  at(kTarget + 2) = draw.uniform(0.5, 3.0);
  at(kTargetYaw) = draw.uniform(-0.72, 0.72);
  at(kStep) = 0.0;
}

}  // namespace skybody::bench::limit
