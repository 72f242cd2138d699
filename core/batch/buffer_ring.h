// The buffers that recv() hands out in turn.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "core/batch/batch.h"

namespace skybody {

/// Three buffers: two that the caller may still read (its last two recv()s), one that is being
/// filled. A buffer that is referred to from outside when its turn comes is left to its holder.
class BufferRing {
 public:
  BufferRing(int rows, const RowWidths& widths, bool with_final, bool debug);

  /// The next buffer to fill. Its turn is over only after commit().
  /// @throws BufferInUse in debug mode if the caller still holds it
  Batch& next();
  /// Hands the buffer of the last next() out.
  std::shared_ptr<const Batch> commit();

  std::uint64_t fresh_buffers() const { return fresh_; }

 private:
  std::shared_ptr<Batch> make() const;

  int rows_;
  RowWidths widths_;
  bool with_final_, debug_;
  std::array<std::shared_ptr<Batch>, 3> buffers_;
  std::size_t turn_ = 0;
  bool ready_ = false;  ///< next() was called in this turn
  std::uint64_t fresh_ = 0;
};

}  // namespace skybody
