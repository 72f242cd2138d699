// The buffers that recv() returns in turn.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "core/batch/batch.h"

namespace skybody {

/// Three buffers: two that the caller may still read (its last two recv()s) and one that is being
/// filled. If the caller still refers to a buffer when its turn comes, the ring leaves it to the
/// caller and makes a fresh one.
class BufferRing {
 public:
  BufferRing(int rows, const RowWidths& widths, bool with_final, bool debug);

  /// The next buffer to fill; the same one until commit().
  /// @throws BufferInUse in debug mode if the caller still holds it
  Batch& next();
  /// Returns the buffer of the last next().
  std::shared_ptr<const Batch> commit();

  std::uint64_t fresh_buffers() const { return fresh_; }

 private:
  std::shared_ptr<Batch> make() const;

  int rows_;
  RowWidths widths_;
  bool with_final_, debug_;
  std::array<std::shared_ptr<Batch>, 3> buffers_;
  std::size_t turn_ = 0;
  bool ready_ = false;  ///< next() was called since the last commit()
  std::uint64_t fresh_ = 0;
};

}  // namespace skybody
