#include "research/bench/learn/held_out.h"

#include <algorithm>
#include <span>
#include <vector>

#include "core/base/system/error.h"
#include "core/batch/pool.h"
#include "core/policy/network_policy.h"
#include "learn/position_error.h"

namespace skybody::bench {
namespace {

constexpr int kLast = 50;  // steps of an episode

/// Values of one episode.
struct Episode {
  NetworkPolicy policy;  // one each: a policy may have state
  std::vector<double> errors = {};
  double sum_of_rewards = 0.0;
  bool is_over = false, has_failed = false;

  double last_error() const {
    const std::size_t count = std::min<std::size_t>(kLast, errors.size());
    double sum = 0.0;
    for (std::size_t k = errors.size() - count; k < errors.size(); ++k) sum += errors[k];
    return sum / static_cast<double>(count);
  }
};

void take_outcome(const Batch& batch, std::size_t row, const learn::PositionError& error,
                  Episode& episode) {
  const bool ends = batch.terminated[row] != 0 || batch.truncated[row] != 0;
  const float* info = (ends ? batch.final_info.data() : batch.info.data()) +
                      row * static_cast<std::size_t>(batch.width.info);
  episode.errors.push_back(error.of(info));
  episode.sum_of_rewards += static_cast<double>(batch.reward[row]);
  episode.is_over = ends;
  episode.has_failed = batch.terminated[row] != 0 || batch.fault[row] != 0;
}

HeldOut figures_of(const std::vector<Episode>& episodes) {
  HeldOut figures;
  std::vector<double> last;
  for (const Episode& episode : episodes) {
    last.push_back(episode.last_error());
    figures.mean_return += episode.sum_of_rewards / kHeldOut;
    if (episode.has_failed) ++figures.failures;
  }
  std::sort(last.begin(), last.end());
  figures.median = 0.5 * (last[kHeldOut / 2 - 1] + last[kHeldOut / 2]);
  figures.worst_tenth = last[kHeldOut * 9 / 10];
  return figures;
}

}  // namespace

HeldOut fly_held_out(const std::shared_ptr<const CompiledScenario>& compiled,
                     const PolicyFile& policy, std::uint64_t seed) {
  const learn::PositionError error = learn::find_position_error(*compiled);
  const int horizon = compiled->scenario().stepping.horizon;
  if (!error.is_told() || horizon == 0) {
    throw Error("`" + compiled->scenario().name +
                "` has no horizon, or its task does not tell the distance from its goal");
  }
  PoolOptions options;
  options.envs = kHeldOut;
  options.threads = 1;
  options.seed = seed;
  options.autoreset = Autoreset::kSameStep;
  Pool pool(compiled, options);
  pool.send_reset();
  auto batch = pool.recv();
  const auto actions = static_cast<std::size_t>(compiled->action_size());
  const auto seen = static_cast<std::size_t>(compiled->observation_size());
  std::vector<float> rows(kHeldOut * actions);
  std::vector<Episode> episodes(kHeldOut, Episode{NetworkPolicy(policy)});
  if (const std::string misfit = episodes[0].policy.check_fits(*compiled); !misfit.empty()) {
    throw Error(misfit);
  }
  for (int t = 0; t < horizon; ++t) {
    for (std::size_t i = 0; i < kHeldOut; ++i) {
      if (episodes[i].is_over) continue;
      const float* from =
          batch->observation.data() + i * static_cast<std::size_t>(batch->width.observation);
      episodes[i].policy.act({from, seen}, {rows.data() + i * actions, actions});
    }
    pool.send(rows);
    batch = pool.recv();
    for (std::size_t i = 0; i < kHeldOut; ++i) {
      if (!episodes[i].is_over) take_outcome(*batch, i, error, episodes[i]);
    }
  }
  return figures_of(episodes);
}

}  // namespace skybody::bench
