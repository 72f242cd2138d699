// Disparities that a matching of a stereo camera's images would find, from depths of both eyes.
#pragma once

#include <skybody/plugin.h>

#include <algorithm>

namespace skybody::stereo {

/// Two pinholes side by side, with the same axes. A point at depth z of the left eye is `product` /
/// z pixels farther left in the right eye's image: its disparity.
struct Matching {
  /// A surface hides points whose disparity is smaller than its own by more than this [pixels]. The
  /// hidden strip is as wide as the difference: narrower ones have no pixel.
  static constexpr double kHiding = 0.5;

  int width, height;  ///< [pixels]
  double product;     ///< focal length times baseline [pixels m]
  float farthest;     ///< depth of nothing [m]

  /// Disparity of a pixel [pixels]; 0: it sees nothing, or a point that is outside of the right
  /// image or hidden from the right eye.
  /// @param left, right  depths
  double disparity(const float* left, const float* right, int pixel) const {
    const float depth = left[pixel];
    if (!(depth > 0.0f && depth < farthest)) return 0.0;
    const double exact = product / static_cast<double>(depth);
    const int column = pixel % width, row = pixel - column;
    const double place = column - exact;  // from the centre of the right image's first pixel
    if (place < -0.5) return 0.0;
    const double before = floor(place);
    const int first = static_cast<int>(before);
    // Only where both pixels beside the place show a nearer surface: a slanted one has the point's
    // disparity between those of the two.
    const double beside = std::min(shown(right[row + std::max(first, 0)]),
                                   shown(right[row + std::min(first + 1, width - 1)]));
    return beside > exact + kHiding ? 0.0 : exact;
  }

  /// Depth of a disparity [m]; of 0 the depth of nothing.
  float depth(double disparity) const {
    if (!(disparity > 0.0)) return farthest;
    return std::min(static_cast<float>(product / disparity), farthest);
  }

 private:
  double shown(float depth) const {
    return depth > 0.0f ? product / static_cast<double>(depth) : kInfinity;
  }
};

/// Error of a disparity: a normal one, then rounding.
struct DisparityNoise {
  double deviation = 0.0;   ///< [pixels]
  double resolution = 0.0;  ///< [pixels]; 0: none

  /// @returns [pixels]; 0: the measured point is at infinity
  double of(double disparity, double normal, int width) const {
    double noisy = disparity + deviation * normal;
    if (resolution > 0.0) noisy = round_half_even(noisy / resolution) * resolution;
    return std::min(std::max(noisy, 0.0), static_cast<double>(width));
  }
};

}  // namespace skybody::stereo
