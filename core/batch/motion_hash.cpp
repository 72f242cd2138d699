#include "core/batch/motion_hash.h"

#include "core/batch/environment_states.h"
#include "core/batch/pool.h"

namespace skybody {
namespace {

void add_block(HashChain& chain, const std::vector<std::uint64_t>& words, const Block& block) {
  for (int k = block.offset; k < block.offset + block.size; ++k) {
    chain.update(canonical_nan(words[static_cast<std::size_t>(k)]));
  }
}

void add_values(HashChain& chain, const Column<float>& values, int row_width, std::size_t row) {
  const auto width = static_cast<std::size_t>(row_width);
  for (std::size_t k = row * width; k < (row + 1) * width; ++k) {
    chain.update(static_cast<double>(values[k]));
  }
}

void add_row(HashChain& chain, const Batch& rows, std::size_t row) {
  add_values(chain, rows.observation, rows.width.observation, row);
  add_values(chain, rows.privileged, rows.width.privileged, row);
  for (std::size_t k = 0; k < rows.images.size(); ++k) {
    const auto width = static_cast<std::size_t>(rows.width.images[k]);
    const std::uint8_t* pixels = rows.images[k].data() + row * width;
    for (std::size_t i = 0; i < width; ++i) chain.update(std::uint64_t{pixels[i]});
  }
  chain.update(static_cast<double>(rows.reward[row]));
  chain.update(rows.status[row]);
}

}  // namespace

MotionHash::MotionHash(const Pool& envs) : chains_(static_cast<std::size_t>(envs.envs())) {}

void MotionHash::received(const Batch& rows, const EnvironmentStates& states) {
  const StateLayout& layout = states.compiled().layout();
  for (std::size_t row = 0; row < static_cast<std::size_t>(rows.rows); ++row) {
    const std::int32_t env = rows.env_id[row];
    HashChain& chain = chains_[static_cast<std::size_t>(env)];
    const std::vector<std::uint64_t> words = states.words(env);
    for (const Block* block : {&layout.q, &layout.u, &layout.rotor_speed}) {
      add_block(chain, words, *block);
    }
    add_row(chain, rows, row);
  }
}

std::uint64_t MotionHash::value() const {
  HashChain all;
  for (const HashChain& chain : chains_) all.update(chain.value());
  return all.value();
}

}  // namespace skybody
