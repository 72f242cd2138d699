// Loops over images: pixels to floats, and sums of overlapping windows.
#pragma once

#include "learn/network/kernels/loops.h"

namespace skybody::learn::kernels::SKYBODY_KERNEL_SET {

inline void scatter(const ScatterCall& call) {
  const Windows& windows = call.windows;
  for (ptrdiff_t r = 0; r < call.rows; ++r) {
    const float* from = call.from + r * call.from_stride;
    float* to = call.x + windows.offsets[r];
    for (int line = 0; line < windows.lines; ++line) {
      add(from, to, static_cast<size_t>(windows.line));
      from += windows.line;
      to += windows.line_step;
    }
  }
}

/// The compiler vectorizes this loop: each pixel has the same operations on every set.
template <class T>
inline void scale_pixels(const PixelCall& call) {
  const T* from = static_cast<const T*>(call.from);
  const float low = call.low, high = call.high, scale = call.scale;
  float* __restrict to = call.to;
  for (size_t i = 0; i < call.count; ++i) {
    const float pixel = static_cast<float>(from[i]);
    const float below = pixel < high ? pixel : high;
    to[i] = ((below > low ? below : low) - low) * scale;
  }
}

inline void pixels(const PixelCall& call) {
  switch (call.type) {
    case PixelType::kFloat32:
      return scale_pixels<float>(call);
    case PixelType::kUint8:
      return scale_pixels<uint8_t>(call);
    case PixelType::kUint16:
      return scale_pixels<uint16_t>(call);
  }
}

}  // namespace skybody::learn::kernels::SKYBODY_KERNEL_SET
