// Errors of images, pixel by pixel.
#pragma once

#include <skybody/plugin.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace skybody::sensor {

/// Calls add(i, standard normal) for i = 0 ... count - 1.
template <class Add>
void each_normal(Random<double> draw, std::size_t count, Add&& add) {
  for (std::size_t i = 0; i < count; i += 2) {
    double errors[2];
    draw.normal_pair(errors[0], errors[1]);
    add(i, errors[0]);
    if (i + 1 < count) add(i + 1, errors[1]);
  }
}

/// Error of a depth or range d: a normal one with the standard deviation base + linear |d| + square
/// d^2, rounded to a multiple of `resolution`. Depths behind a fisheye are negative and stay so.
struct DepthNoise {
  double base = 0.0, linear = 0.0, square = 0.0;  ///< [m], [1], [1/m]
  double resolution = 0.0;                        ///< [m]; 0: none
  float farthest = 0.0f;                          ///< of the image [m]: nothing, without an error

  bool is_on() const { return base > 0.0 || linear > 0.0 || square > 0.0 || resolution > 0.0; }

  float of(float depth, double normal) const {
    if (depth >= farthest) return farthest;
    const double size = std::abs(static_cast<double>(depth));
    double noisy = size + normal * (base + size * (linear + size * square));
    if (resolution > 0.0) noisy = round_half_even(noisy / resolution) * resolution;
    const float held = std::min(static_cast<float>(std::max(noisy, 0.0)), farthest);
    return depth < 0.0f ? -held : held;
  }
};

/// Adds noise to an image of depths or ranges.
inline void add_noise(const DepthNoise& noise, const Random<double>& draw, std::size_t pixels,
                      float* depth) {
  each_normal(draw, pixels,
              [&](std::size_t i, double normal) { depth[i] = noise.of(depth[i], normal); });
}

/// Marks pixels beside a jump of depth, each with a probability: stereo and time-of-flight cameras
/// measure nothing there. A jump is a difference above `kJump` of the smaller depth.
class EdgeHoles {
 public:
  static constexpr float kJump = 0.05f;

  EdgeHoles(int width, int height) : width_(width), height_(height) {}

  /// @param is_hole  one byte per pixel, written
  void find(const float* depth, double probability, Random<double> draw,
            std::uint8_t* is_hole) const {
    for (int row = 0; row < height_; ++row) {
      for (int column = 0; column < width_; ++column) {
        const int at = row * width_ + column;
        is_hole[at] = is_edge(depth, row, column) && draw.uniform() < probability ? 1 : 0;
      }
    }
  }
  void fill(const std::uint8_t* is_hole, float value, float* depth) const {
    for (int i = 0; i < width_ * height_; ++i) depth[i] = is_hole[i] != 0 ? value : depth[i];
  }

 private:
  bool is_edge(const float* depth, int row, int column) const {
    const float own = depth[row * width_ + column];
    const auto jumps = [&](int r, int c) {
      if (r < 0 || r >= height_ || c < 0 || c >= width_) return false;
      const float other = depth[r * width_ + c];
      return std::abs(other - own) > kJump * std::min(std::abs(own), std::abs(other));
    };
    return jumps(row - 1, column) || jumps(row + 1, column) || jumps(row, column - 1) ||
           jumps(row, column + 1);
  }

  int width_, height_;
};

/// Noise of colours in [0, 1]: the variance of a colour c is base^2 + shot^2 c.
struct ColorNoise {
  double base = 0.0;  ///< standard deviation in the dark, as a share of the whole range
  double shot = 0.0;  ///< that of full brightness by the counting of photons, likewise

  bool is_on() const { return base > 0.0 || shot > 0.0; }
  double deviation(double color) const {
    return shot > 0.0 ? std::sqrt(base * base + shot * shot * color) : base;
  }
};

/// Adds noise to bytes.
inline void add_noise(const ColorNoise& noise, const Random<double>& draw, std::size_t count,
                      std::uint8_t* bytes) {
  double deviations[256];
  for (int c = 0; c < 256; ++c) deviations[c] = 255.0 * noise.deviation(c / 255.0);
  each_normal(draw, count, [&](std::size_t i, double normal) {
    const double noisy = static_cast<double>(bytes[i]) + deviations[bytes[i]] * normal;
    bytes[i] = static_cast<std::uint8_t>(std::min(std::max(noisy + 0.5, 0.0), 255.0));
  });
}

}  // namespace skybody::sensor
