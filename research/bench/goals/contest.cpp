#include "research/bench/goals/contest.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "app/batch_actions.h"
#include "core/batch/pool.h"
#include "research/bench/limit/rate.h"

namespace skybody::bench {
namespace {

/// Actions of a stream, precomputed.
class Stream {
 public:
  /// @param constant  value of all actions, in place of the stream `name`
  Stream(const std::string& name, std::optional<float> constant,
         const std::shared_ptr<const CompiledScenario>& compiled, int envs)
      : rows_(static_cast<std::size_t>(envs)),
        same_(constant ? rows_ * static_cast<std::size_t>(compiled->action_size()) : 0,
              constant.value_or(0.0f)),
        rest_(constant ? "zero" : name, compiled, envs) {}
  std::span<const float> next() { return same_.empty() ? rest_.next(rows_) : std::span(same_); }

 private:
  std::size_t rows_;
  std::vector<float> same_;
  BatchActions rest_;
};

std::shared_ptr<const CompiledScenario> load(const Contest& contest) {
  LoadOptions options = contest.scenario;
  options.overrides.push_back("stepping.action_repeat=" + std::to_string(contest.repeats));
  return compile_scenario(options);
}

/// All environments, sent and received in rounds, as a learner does.
class Ours {
 public:
  explicit Ours(const Contest& contest)
      : compiled_(load(contest)),
        envs_(compiled_, options_of(contest)),
        stream_(contest.actions, contest.constant, compiled_, contest.envs) {
    envs_.send_reset();
    envs_.recv();
    const double step = compiled_->scenario().stepping.dt * contest.repeats;
    for (double time = 0.0; time <= contest.settle; time += step) round();
  }
  double rate(double seconds) {
    return envs_.envs() * limit::rounds_per_second([&] { round(); }, seconds);
  }
  double near_share() const {
    const StepCounts counts = envs_.step_counts();
    return static_cast<double>(counts.near) / static_cast<double>(counts.all);
  }

 private:
  static PoolOptions options_of(const Contest& contest) {
    PoolOptions options;
    options.envs = contest.envs;
    options.threads = contest.threads;
    options.info = false;  // the limit has no infos
    return options;
  }
  void round() {
    envs_.send(stream_.next());
    envs_.recv();
  }

  std::shared_ptr<const CompiledScenario> compiled_;
  Pool envs_;
  Stream stream_;
};

/// One limit loop under the same actions.
class Limit {
 public:
  Limit(const Contest& contest, const limit::LoopKind& loop)
      : array_(loop, contest.envs, contest.repeats),
        stream_(contest.limit_actions.empty()
                    ? Stream(contest.actions, contest.constant, load(contest), contest.envs)
                    : Stream(contest.limit_actions, {}, load(contest), contest.envs)),
        threads_(contest.threads) {}
  double rate(double seconds) {
    const auto work = [&](int share) { array_.step(rows_, share, threads_); };
    if (threads_ == 1) {
      return array_.envs() * limit::rounds_per_second(
                                 [&] {
                                   rows_ = stream_.next().data();
                                   work(0);
                                 },
                                 seconds);
    }
    limit::SpinningPair pair(work);
    return array_.envs() * limit::rounds_per_second(
                               [&] {
                                 rows_ = stream_.next().data();
                                 pair.run();
                               },
                               seconds);
  }

 private:
  limit::EnvironmentArray array_;
  Stream stream_;
  int threads_;
  const float* rows_ = nullptr;  ///< of the current round
};

}  // namespace

Outcome run_contest(const Contest& contest, const Effort& effort) {
  Ours ours(contest);
  std::vector<std::unique_ptr<Limit>> limits;
  std::vector<double> best(contest.loops.size());
  for (const limit::LoopKind& loop : contest.loops) {
    limits.push_back(std::make_unique<Limit>(contest, loop));
  }
  Outcome out;
  for (int trial = 0; trial < effort.trials; ++trial) {
    out.ours = std::max(out.ours, ours.rate(effort.seconds));
    for (std::size_t k = 0; k < limits.size(); ++k) {
      best[k] = std::max(best[k], limits[k]->rate(effort.seconds));
    }
  }
  const auto first = std::max_element(best.begin(), best.end());
  out.limit = *first;
  out.near_share = ours.near_share();
  out.loop = contest.loops[static_cast<std::size_t>(first - best.begin())].name;
  return out;
}

double engine_rate(const Contest& contest, const Effort& effort) {
  Ours ours(contest);
  double best = 0.0;
  for (int trial = 0; trial < effort.trials; ++trial) {
    best = std::max(best, ours.rate(effort.seconds));
  }
  return best;
}

}  // namespace skybody::bench
