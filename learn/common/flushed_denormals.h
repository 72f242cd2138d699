// Floating-point mode of learning: denormal numbers are flushed to zero.
#pragma once

#ifdef __SSE2__
#include <xmmintrin.h>
#endif

namespace skybody::learn {

/// Within its scope, denormal operands and results count as zero. No effect on processors without
/// SSE.
class FlushedDenormals {
 public:
#ifdef __SSE2__
  FlushedDenormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | kFlushToZero | kReadAsZero); }
  ~FlushedDenormals() { _mm_setcsr(before_); }

 private:
  static constexpr unsigned kFlushToZero = 0x8000, kReadAsZero = 0x0040;
  unsigned before_;
#else
  FlushedDenormals() {}
  ~FlushedDenormals() {}
#endif

 public:
  FlushedDenormals(const FlushedDenormals&) = delete;
  FlushedDenormals& operator=(const FlushedDenormals&) = delete;
};

}  // namespace skybody::learn
