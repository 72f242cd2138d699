#include "tests/fuzz/batch_rows.h"

#include <cstring>
#include <span>
#include <string>

#include "tests/fuzz/finding.h"

namespace skybody::fuzz {
namespace {

void append(const Column<float>& column, int width, int row, std::vector<std::uint32_t>& words) {
  words.resize(words.size() + static_cast<std::size_t>(width));
  std::memcpy(words.data() + words.size() - width, column.data() + row * width,
              static_cast<std::size_t>(width) * sizeof(float));
}

std::span<const float> row_of(const Column<float>& column, int width, int row) {
  return std::span(column).subspan(static_cast<std::size_t>(row * width),
                                   static_cast<std::size_t>(width));
}

}  // namespace

BatchRows BatchRows::receive(Pool& envs, Faults faults) {
  BatchRows rows;
  rows.words_.resize(static_cast<std::size_t>(envs.envs()));
  while (envs.in_flight() > 0) {
    const auto batch = envs.recv();
    for (int row = 0; row < batch->rows; ++row) rows.add(*batch, row, faults);
  }
  return rows;
}

void BatchRows::add(const Batch& batch, int row, Faults faults) {
  const auto k = static_cast<std::size_t>(row);
  if (faults == Faults::kAreFinite || batch.fault[k] == 0) {
    check_finite("observation", row_of(batch.observation, batch.width.observation, row));
    check_finite("reward", row_of(batch.reward, 1, row));
    check_finite("agent reward", row_of(batch.agent_reward, batch.width.agents, row));
  }
  if (batch.fault[k] == 0) check_finite("info", row_of(batch.info, batch.width.info, row));
  std::vector<std::uint32_t>& words = words_[static_cast<std::size_t>(batch.env_id[k])];
  append(batch.observation, batch.width.observation, row, words);
  append(batch.reward, 1, row, words);
  append(batch.agent_reward, batch.width.agents, row, words);
  append(batch.info, batch.width.info, row, words);
  words.push_back(static_cast<std::uint32_t>(batch.status[k]));
  words.push_back(static_cast<std::uint32_t>(batch.episode_step[k]));
}

void check_others(const BatchRows& rows, const BatchRows& expected, int envs, int changed) {
  for (int env = 0; env < envs; ++env) {
    if (env == changed || rows.of(env) == expected.of(env)) continue;
    silent_change("environment " + std::to_string(env) + " has other rows beside a changed " +
                  std::to_string(changed));
  }
}

}  // namespace skybody::fuzz
