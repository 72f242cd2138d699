#include "learn/gradient/horizon_inputs.h"

#include <algorithm>

#include "core/base/simd/lane_mask.h"
#include "core/derivative/transition_adjoint.h"
#include "learn/network/panel_matrix.h"

namespace skybody::learn {
namespace {

std::size_t lanes_of(int width) {
  return static_cast<std::size_t>(kGroupLanes) * static_cast<std::size_t>(width);
}

}  // namespace

HorizonInputs::HorizonInputs(const CompiledScenario& compiled, bool has_value, int steps,
                             int groups)
    : compiled_(compiled),
      seen_(compiled.observation_size()),
      width_(seen_ + (has_value ? compiled.privileged_size() : 0)),
      stride_(padded(width_)),
      task_rows_(task_rows(compiled)),
      observation_(lanes_of(seen_)),
      privileged_(lanes_of(width_ - seen_)),
      present_(static_cast<std::size_t>(groups) * lanes_of(width_)),
      rows_(static_cast<std::size_t>(steps) * lanes_of(stride_)),
      end_(lanes_of(stride_)) {
  for (const ObservedImage& image : compiled.images()) {
    images_.emplace_back(static_cast<std::size_t>(steps) * lanes_of(image.bytes));
  }
}

Rows HorizonInputs::outcome(float* reward, std::uint64_t* status) {
  Rows rows{observation_.data(), reward, status};
  if (width_ > seen_) rows.privileged = privileged_.data();
  return rows;
}

void HorizonInputs::take(int env, int lane) {
  float* const to = present_.data() + at(env);
  const int privileged = width_ - seen_;
  std::copy_n(observation_.data() + lane * seen_, seen_, to);
  std::copy_n(privileged_.data() + lane * privileged, privileged, to + seen_);
}

void HorizonInputs::normalize(int env, std::span<const double> mean, std::span<const double> scale,
                              float* to) const {
  const std::span<const float> values = present(env);
  for (std::size_t k = 0; k < values.size(); ++k) {
    to[k] = static_cast<float>((static_cast<double>(values[k]) - mean[k]) * scale[k]);
  }
}

void HorizonInputs::keep_images(const StateGroup& group, std::uint32_t lanes, int t) {
  for (std::size_t k = 0; k < images_.size(); ++k) {
    const ObservedImage& image = compiled_.images()[k];
    each_lane(lanes, [&](int l) {
      std::copy_n(group.images().bytes_of(l) + image.from, image.bytes,
                  images_[k].data() + place(t, l) * image.bytes);
    });
  }
}

}  // namespace skybody::learn
