#include "core/batch/buffer_ring.h"

namespace skybody {

BufferRing::BufferRing(int rows, const RowWidths& widths, bool with_final, bool debug)
    : rows_(rows), widths_(widths), with_final_(with_final), debug_(debug) {
  for (auto& buffer : buffers_) buffer = make();
}

std::shared_ptr<Batch> BufferRing::make() const {
  return std::make_shared<Batch>(rows_, widths_, with_final_);
}

Batch& BufferRing::next() {
  std::shared_ptr<Batch>& buffer = buffers_[turn_];
  if (ready_) return *buffer;
  if (buffer.use_count() > 1) {
    if (debug_) {
      throw BufferInUse(
          "the buffer of the third last recv() is still referred to: copy what you keep longer "
          "than two recv()s, or leave debug mode, where such a buffer is replaced");
    }
    buffer = make();
    ++fresh_;
  } else if (debug_) {
    buffer->poison();
  }
  ready_ = true;
  return *buffer;
}

std::shared_ptr<const Batch> BufferRing::commit() {
  std::shared_ptr<const Batch> out = buffers_[turn_];
  turn_ = (turn_ + 1) % buffers_.size();
  ready_ = false;
  return out;
}

}  // namespace skybody
