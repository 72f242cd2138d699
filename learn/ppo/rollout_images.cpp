#include "learn/ppo/rollout_images.h"

#include <algorithm>

namespace skybody::learn {

RolloutImages::RolloutImages(const PpoSetup& setup, int envs, std::size_t rows)
    : envs_(static_cast<std::size_t>(envs)), current_(setup.images.size()) {
  for (const SeenImage& image : setup.images) {
    const auto bytes = static_cast<std::size_t>(image.format.bytes());
    bytes_.push_back(bytes);
    images_.emplace_back(rows * bytes);
    last_.emplace_back(envs_ * bytes);
    own_.emplace_back(envs_ * bytes);
  }
}

void RolloutImages::look_at(const Pool& pool) {
  for (std::size_t k = 0; k < own_.size(); ++k) {
    pool.image(static_cast<int>(k), {own_[k].data(), own_[k].size()});
    current_[k] = own_[k].data();
  }
}

void RolloutImages::look_at(const Batch& batch) {
  for (std::size_t k = 0; k < current_.size(); ++k) current_[k] = batch.images[k].data();
}

void RolloutImages::write(std::size_t first) {
  for (std::size_t k = 0; k < images_.size(); ++k) {
    std::copy_n(current_[k], envs_ * bytes_[k], images_[k].data() + first * bytes_[k]);
  }
}

void RolloutImages::keep_last(const Batch& batch, int env, std::size_t place) {
  for (std::size_t k = 0; k < last_.size(); ++k) {
    const std::uint8_t* from =
        batch.final_images[k].data() + static_cast<std::size_t>(env) * bytes_[k];
    std::copy_n(from, bytes_[k], last_[k].data() + place * bytes_[k]);
  }
}

}  // namespace skybody::learn
