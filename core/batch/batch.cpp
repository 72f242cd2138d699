#include "core/batch/batch.h"

#include <algorithm>
#include <limits>

namespace skybody {
namespace {

template <class T>
void copy_row(const Column<T>& from, int i, Column<T>& to, int j, int width, int count) {
  std::copy_n(from.data() + static_cast<std::ptrdiff_t>(i) * width,
              static_cast<std::ptrdiff_t>(count) * width,
              to.data() + static_cast<std::ptrdiff_t>(j) * width);
}

}  // namespace

Batch::Batch(int row_capacity, const RowWidths& row_widths, bool with_final) : width(row_widths) {
  const auto n = static_cast<std::size_t>(row_capacity);
  const auto observations = n * static_cast<std::size_t>(width.observation);
  const auto infos = n * static_cast<std::size_t>(width.info);
  observation.resize(observations);
  reward.resize(n);
  agent_reward.resize(n * static_cast<std::size_t>(width.agents));
  info.resize(infos);
  privileged.resize(n * static_cast<std::size_t>(width.privileged));
  for (const int bytes : width.images) images.emplace_back(n * static_cast<std::size_t>(bytes));
  status.resize(n);
  terminated.resize(n);
  truncated.resize(n);
  fault.resize(n);
  was_reset.resize(n);
  env_id.resize(n);
  episode_step.resize(n);
  if (with_final) {
    final_observation.resize(observations);
    final_info.resize(infos);
    final_privileged.resize(privileged.size());
    final_images = images;
  }
}

void Batch::take(const Batch& from, int first, int count, int at) {
  copy_row(from.observation, first, observation, at, width.observation, count);
  copy_row(from.reward, first, reward, at, 1, count);
  copy_row(from.agent_reward, first, agent_reward, at, width.agents, count);
  copy_row(from.info, first, info, at, width.info, count);
  copy_row(from.privileged, first, privileged, at, width.privileged, count);
  for (std::size_t k = 0; k < images.size(); ++k) {
    copy_row(from.images[k], first, images[k], at, width.images[k], count);
  }
  copy_row(from.status, first, status, at, 1, count);
  copy_row(from.terminated, first, terminated, at, 1, count);
  copy_row(from.truncated, first, truncated, at, 1, count);
  copy_row(from.fault, first, fault, at, 1, count);
  copy_row(from.was_reset, first, was_reset, at, 1, count);
  copy_row(from.env_id, first, env_id, at, 1, count);
  copy_row(from.episode_step, first, episode_step, at, 1, count);
  if (final_observation.empty()) return;
  for (int k = 0; k < count; ++k) {
    if (from.status[static_cast<std::size_t>(first + k)] == 0) continue;  // no episode ended
    copy_row(from.final_observation, first + k, final_observation, at + k, width.observation, 1);
    copy_row(from.final_info, first + k, final_info, at + k, width.info, 1);
    copy_row(from.final_privileged, first + k, final_privileged, at + k, width.privileged, 1);
    for (std::size_t i = 0; i < images.size(); ++i) {
      copy_row(from.final_images[i], first + k, final_images[i], at + k, width.images[i], 1);
    }
  }
}

void Batch::keep_final(int row) {
  copy_row(observation, row, final_observation, row, width.observation, 1);
  copy_row(info, row, final_info, row, width.info, 1);
  copy_row(privileged, row, final_privileged, row, width.privileged, 1);
  for (std::size_t k = 0; k < images.size(); ++k) {
    copy_row(images[k], row, final_images[k], row, width.images[k], 1);
  }
}

void Batch::poison() {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  for (Column<float>* column : {&observation, &reward, &agent_reward, &info, &privileged,
                                &final_observation, &final_info, &final_privileged}) {
    std::fill(column->begin(), column->end(), kNaN);
  }
}

}  // namespace skybody
