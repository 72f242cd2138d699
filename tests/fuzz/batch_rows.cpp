#include "tests/fuzz/batch_rows.h"

#include <cmath>
#include <cstring>
#include <string>

#include "tests/fuzz/finding.h"

namespace skybody::fuzz {
namespace {

void append(const Column<float>& column, int width, int row, const char* what,
            std::vector<std::uint32_t>& words) {
  for (int k = 0; k < width; ++k) {
    const float value = column[static_cast<std::size_t>(row * width + k)];
    if (!std::isfinite(value)) {
      wrong_answer(std::string(what) + " " + std::to_string(k) + " is not finite");
    }
    words.emplace_back();
    std::memcpy(&words.back(), &value, sizeof value);
  }
}

}  // namespace

BatchRows BatchRows::receive(VecEnv& envs) {
  BatchRows rows;
  rows.words_.resize(static_cast<std::size_t>(envs.envs()));
  while (envs.in_flight() > 0) {
    const auto batch = envs.recv();
    for (int row = 0; row < batch->rows; ++row) rows.add(*batch, row);
  }
  return rows;
}

void BatchRows::add(const Batch& batch, int row) {
  const auto k = static_cast<std::size_t>(row);
  std::vector<std::uint32_t>& words = words_[static_cast<std::size_t>(batch.env_id[k])];
  append(batch.observation, batch.width.observation, row, "observation", words);
  append(batch.reward, 1, row, "reward", words);
  append(batch.agent_reward, batch.width.agents, row, "agent reward", words);
  append(batch.info, batch.width.info, row, "info", words);
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
