#include "core/simulation/simulation_pool.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <numeric>
#include <utility>

#include "core/base/arguments.h"
#include "core/base/error.h"
#include "core/base/processors.h"
#include "core/batch/crew.h"
#include "core/batch/vec_env_options.h"

namespace skybody {
namespace {

SimulationPoolOptions checked(SimulationPoolOptions options) {
  check_range("number of worlds", options.worlds, 1, kMostEnvs, "take at least one");
  check_range("threads", options.threads, 0, kMostThreads, "take 0 for one per processor");
  if (options.threads == 0) {
    options.threads = std::min(static_cast<int>(allowed_processors().size()), options.worlds);
  }
  return options;
}

}  // namespace

/// The worlds and the threads that work in them.
class SimulationPool::Worlds final : GroupRunner {
 public:
  Worlds(const std::shared_ptr<const Environment>& environment,
         const SimulationPoolOptions& options)
      : crew_(options.threads, options.worlds, options.pin_threads, *this) {
    failures_.resize(static_cast<std::size_t>(options.worlds));
    worlds_.reserve(failures_.size());
    for (int i = 0; i < options.worlds; ++i) {
      worlds_.emplace_back(environment, options.seed,
                           options.first_env_id + static_cast<std::uint64_t>(i));
    }
  }

  const Crew& crew() const { return crew_; }
  Simulation& operator[](int world) { return worlds_[static_cast<std::size_t>(world)]; }

  /// Does the work in some worlds and waits for all of them. @returns what each threw, in the order
  /// of `chosen`; null: nothing
  std::span<std::exception_ptr> run(std::span<const int> chosen, const Work& work) {
    chosen_ = chosen;
    work_ = &work;
    left_.store(static_cast<int>(chosen.size()), std::memory_order_relaxed);
    crew_.submit_unknown(static_cast<int>(chosen.size()));
    crew_.wait([this] { return left_.load(std::memory_order_seq_cst) == 0; },
               Crew::Clock::time_point::max());
    return std::span(failures_).first(chosen.size());
  }

 private:
  /// A group is a place within the chosen worlds.
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
    crew_.announce();
  }

  std::vector<Simulation> worlds_;
  std::vector<std::exception_ptr> failures_;  ///< one per place within the chosen worlds
  std::span<const int> chosen_;
  const Work* work_ = nullptr;
  std::atomic<int> left_{0};  ///< chosen worlds that are not yet done
  Crew crew_;                 ///< last: its threads use the rest
};

SimulationPool::SimulationPool(std::shared_ptr<const Environment> environment,
                               const SimulationPoolOptions& options)
    : environment_(std::move(environment)) {
  const SimulationPoolOptions completed = checked(options);
  all_.resize(static_cast<std::size_t>(completed.worlds));
  std::iota(all_.begin(), all_.end(), 0);
  rows_.resize(all_.size());
  worlds_ = std::make_unique<Worlds>(environment_, completed);
  threads_ = worlds_->crew().threads();
  pinned_ = worlds_->crew().pinned();
}

SimulationPool::~SimulationPool() = default;

void SimulationPool::close() { worlds_.reset(); }

void SimulationPool::check_open() const {
  if (closed()) throw Error("this pool of simulations is closed: make a new one");
}

void SimulationPool::check(std::span<const int> worlds) const {
  check_open();
  check_indices("world", worlds, size());
}

Simulation& SimulationPool::world(int index) {
  check_open();
  check_index("world", index, size());
  return (*worlds_)[index];
}

void SimulationPool::run(std::span<const int> worlds, const Work& work) {
  check(worlds);
  if (worlds.empty()) return;
  int first = size();
  std::exception_ptr failure;
  const std::span<std::exception_ptr> thrown = worlds_->run(worlds, work);
  for (std::size_t k = 0; k < worlds.size(); ++k) {
    const std::exception_ptr what = std::exchange(thrown[k], nullptr);
    if (what && worlds[k] < first) {
      first = worlds[k];
      failure = what;
    }
  }
  if (!failure) return;
  const std::string where = "world " + std::to_string(first) + ": ";
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    throw Error(where + error.what());
  } catch (...) {
    throw Error(where + "its work threw something that is no std::exception");
  }
}

void SimulationPool::reset(std::span<const int> worlds) {
  run(worlds, [](Simulation& world, int) { world.reset(); });
}

void SimulationPool::reset(std::span<const int> worlds, std::uint64_t seed) {
  run(worlds, [seed](Simulation& world, int) { world.reset(seed); });
}

void SimulationPool::step(std::span<const int> worlds, std::span<const float> actions) {
  check(worlds);
  const int width = environment_->action_size();
  check_values("actions", actions.size(), worlds.size(), width);
  const auto count = static_cast<std::size_t>(width);
  for (std::size_t k = 0; k < worlds.size(); ++k) rows_[static_cast<std::size_t>(worlds[k])] = k;
  run(worlds, [&](Simulation& world, int i) {
    world.step(actions.subspan(rows_[static_cast<std::size_t>(i)] * count, count));
  });
}

void SimulationPool::command(std::span<const int> worlds, const std::string& robot,
                             std::span<const double> values) {
  check(worlds);
  if (worlds.empty()) return;
  const int width = (*worlds_)[worlds.front()].command_size(robot);
  check_values("values", values.size(), worlds.size(), width);
  const auto count = static_cast<std::size_t>(width);
  for (std::size_t k = 0; k < worlds.size(); ++k) {
    try {  // too little work for a thread
      (*worlds_)[worlds[k]].command(robot, values.subspan(k * count, count));
    } catch (const Error& error) {
      throw Error("world " + std::to_string(worlds[k]) + ": " + error.what());
    }
  }
}

void SimulationPool::advance(std::span<const int> worlds, std::int64_t physics_steps) {
  run(worlds, [physics_steps](Simulation& world, int) { world.advance(physics_steps); });
}

void SimulationPool::evaluate(std::span<const int> worlds) {
  run(worlds, [](Simulation& world, int) { world.evaluate(); });
}

void SimulationPool::state(std::string_view path, std::span<double> values) {
  check_open();
  const StateValue& value = environment_->state_values().at(path);
  check_values("values", values.size(), all_.size(), value.count());
  const auto count = static_cast<std::size_t>(value.count());
  for (const int i : all_) {
    (*worlds_)[i].state(value, values.subspan(static_cast<std::size_t>(i) * count, count));
  }
}

}  // namespace skybody
