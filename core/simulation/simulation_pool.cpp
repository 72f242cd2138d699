#include "core/simulation/simulation_pool.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <numeric>
#include <utility>

#include "core/base/system/arguments.h"
#include "core/base/system/error.h"
#include "core/base/system/processors.h"
#include "core/batch/pool_options.h"
#include "core/batch/thread_pool.h"

namespace skybody {
namespace {

SimulationPoolOptions checked(SimulationPoolOptions options) {
  check_range("number of environments", options.envs, 1, kMostEnvs, "take at least one");
  check_range("threads", options.threads, 0, kMostThreads, "take 0 for one per processor");
  if (options.threads == 0) {
    options.threads = std::min(static_cast<int>(allowed_processors().size()), options.envs);
  }
  return options;
}

}  // namespace

/// The environments and the threads that work on them.
class SimulationPool::Simulations final : GroupRunner {
 public:
  Simulations(const std::shared_ptr<const CompiledScenario>& compiled,
              const SimulationPoolOptions& options)
      : threads_(options.threads, options.envs, options.pin_threads, *this) {
    failures_.resize(static_cast<std::size_t>(options.envs));
    simulations_.reserve(failures_.size());
    for (int i = 0; i < options.envs; ++i) {
      simulations_.emplace_back(compiled, options.seed,
                                options.first_env_id + static_cast<std::uint64_t>(i));
    }
  }

  const ThreadPool& threads() const { return threads_; }
  Simulation& operator[](int sim) { return simulations_[static_cast<std::size_t>(sim)]; }

  /// Runs the work in some environments and waits for all of them. @returns the exceptions in the
  /// order of `chosen`; null: none
  std::span<std::exception_ptr> run(std::span<const int> chosen, const Work& work) {
    chosen_ = chosen;
    work_ = &work;
    left_.store(static_cast<int>(chosen.size()), std::memory_order_relaxed);
    threads_.submit_unknown(static_cast<int>(chosen.size()));
    threads_.wait([this] { return left_.load(std::memory_order_seq_cst) == 0; },
                  ThreadPool::Clock::time_point::max());
    return std::span(failures_).first(chosen.size());
  }

 private:
  /// A group is an index within the chosen environments.
  void run(const int* groups, int count, int /*thread*/) override {
    for (int k = 0; k < count; ++k) {
      const auto place = static_cast<std::size_t>(groups[k]);
      try {
        (*work_)((*this)[chosen_[place]], chosen_[place]);
      } catch (...) {
        failures_[place] = std::current_exception();
      }
    }
    left_.fetch_sub(count, std::memory_order_seq_cst);
    threads_.announce();
  }

  std::vector<Simulation> simulations_;
  std::vector<std::exception_ptr> failures_;  ///< one per chosen environment
  std::span<const int> chosen_;
  const Work* work_ = nullptr;
  std::atomic<int> left_{0};  ///< chosen environments that are not yet done
  ThreadPool threads_;        ///< last: its threads use the other members
};

SimulationPool::SimulationPool(std::shared_ptr<const CompiledScenario> compiled,
                               const SimulationPoolOptions& options)
    : compiled_(std::move(compiled)) {
  const SimulationPoolOptions completed = checked(options);
  all_.resize(static_cast<std::size_t>(completed.envs));
  std::iota(all_.begin(), all_.end(), 0);
  rows_.resize(all_.size());
  simulations_ = std::make_unique<Simulations>(compiled_, completed);
  threads_ = simulations_->threads().threads();
  pinned_ = simulations_->threads().pinned();
}

SimulationPool::~SimulationPool() = default;

void SimulationPool::close() { simulations_.reset(); }

void SimulationPool::check_open() const {
  if (closed()) throw Error("this pool of simulations is closed: make a new one");
}

void SimulationPool::check(std::span<const int> envs) const {
  check_open();
  check_indices("environment", envs, size());
}

Simulation& SimulationPool::simulation(int index) {
  check_open();
  check_index("environment", index, size());
  return (*simulations_)[index];
}

void SimulationPool::run(std::span<const int> envs, const Work& work) {
  check(envs);
  if (envs.empty()) return;
  int first = size();
  std::exception_ptr failure;
  const std::span<std::exception_ptr> thrown = simulations_->run(envs, work);
  for (std::size_t k = 0; k < envs.size(); ++k) {
    const std::exception_ptr what = std::exchange(thrown[k], nullptr);
    if (what && envs[k] < first) {
      first = envs[k];
      failure = what;
    }
  }
  if (!failure) return;
  const std::string where = "environment " + std::to_string(first) + ": ";
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    throw Error(where + error.what());
  } catch (...) {
    throw Error(where + "its work threw something that is no std::exception");
  }
}

void SimulationPool::reset(std::span<const int> envs) {
  run(envs, [](Simulation& sim, int) { sim.reset(); });
}

void SimulationPool::reset(std::span<const int> envs, std::uint64_t seed) {
  run(envs, [seed](Simulation& sim, int) { sim.reset(seed); });
}

void SimulationPool::step(std::span<const int> envs, std::span<const float> actions) {
  check(envs);
  const int width = compiled_->action_size();
  check_values("actions", actions.size(), envs.size(), width);
  const auto count = static_cast<std::size_t>(width);
  for (std::size_t k = 0; k < envs.size(); ++k) rows_[static_cast<std::size_t>(envs[k])] = k;
  run(envs, [&](Simulation& sim, int i) {
    sim.step(actions.subspan(rows_[static_cast<std::size_t>(i)] * count, count));
  });
}

void SimulationPool::command(std::span<const int> envs, const std::string& robot,
                             std::span<const double> values) {
  check(envs);
  if (envs.empty()) return;
  const int width = (*simulations_)[envs.front()].command_size(robot);
  check_values("values", values.size(), envs.size(), width);
  const auto count = static_cast<std::size_t>(width);
  for (std::size_t k = 0; k < envs.size(); ++k) {
    try {  // too little work for a thread
      (*simulations_)[envs[k]].command(robot, values.subspan(k * count, count));
    } catch (const Error& error) {
      throw Error("environment " + std::to_string(envs[k]) + ": " + error.what());
    }
  }
}

void SimulationPool::advance(std::span<const int> envs, std::int64_t physics_steps) {
  run(envs, [physics_steps](Simulation& sim, int) { sim.advance(physics_steps); });
}

void SimulationPool::evaluate(std::span<const int> envs) {
  run(envs, [](Simulation& sim, int) { sim.evaluate(); });
}

void SimulationPool::state(std::string_view path, std::span<double> values) {
  check_open();
  const StateValue& value = compiled_->state_values().at(path);
  check_values("values", values.size(), all_.size(), value.count());
  const auto count = static_cast<std::size_t>(value.count());
  for (const int i : all_) {
    (*simulations_)[i].state(value, values.subspan(static_cast<std::size_t>(i) * count, count));
  }
}

}  // namespace skybody
