#include "core/simulation/simulation_pool.h"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <numeric>
#include <system_error>
#include <thread>
#include <utility>

#include "core/base/arguments.h"
#include "core/base/error.h"
#include "core/base/fp_environment.h"
#include "core/base/processors.h"

namespace skybody {

/// One world and its thread, which sleeps while there is no work.
class SimulationPool::Worker {
 public:
  Worker(Simulation simulation, int index)
      : simulation_(std::move(simulation)), index_(index), thread_([this] { live(); }) {}

  ~Worker() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_one();
    thread_.join();
  }

  Simulation& simulation() { return simulation_; }
  std::thread& thread() { return thread_; }

  /// Hands work over; it must live until finish() has returned.
  void begin(const Work& work) {
    {
      const std::lock_guard lock(mutex_);
      work_ = &work;
    }
    wake_.notify_one();
  }

  /// Waits for the work's end. @returns what it threw, if anything
  std::exception_ptr finish() {
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return work_ == nullptr; });
    return std::exchange(failure_, nullptr);
  }

 private:
  void live() {
    const FpEnvironment guard;
    std::unique_lock lock(mutex_);
    for (;;) {
      wake_.wait(lock, [this] { return stop_ || work_ != nullptr; });
      if (work_ == nullptr) return;
      const Work& work = *work_;
      lock.unlock();
      std::exception_ptr failure;
      try {
        work(simulation_, index_);
      } catch (...) {
        failure = std::current_exception();
      }
      lock.lock();
      failure_ = failure;
      work_ = nullptr;
      done_.notify_one();
    }
  }

  Simulation simulation_;
  const int index_;
  std::mutex mutex_;
  std::condition_variable wake_, done_;
  const Work* work_ = nullptr;
  std::exception_ptr failure_;
  bool stop_ = false;
  std::thread thread_;  ///< last: it uses all of the above
};

SimulationPool::SimulationPool(std::shared_ptr<const Environment> environment,
                               const SimulationPoolOptions& options)
    : environment_(std::move(environment)) {
  constexpr int kMostWorlds = 4096;  // each is a thread
  check_range("number of worlds", options.worlds, 1, kMostWorlds,
              "each has a thread; VecEnv has no such limit");
  all_.resize(static_cast<std::size_t>(options.worlds));
  std::iota(all_.begin(), all_.end(), 0);
  const std::vector<int> processors =
      options.pin_threads ? allowed_processors() : std::vector<int>();
  try {
    for (const int i : all_) {
      const auto id = static_cast<std::uint64_t>(i);
      workers_.push_back(std::make_unique<Worker>(
          Simulation(environment_, options.seed, options.first_env_id + id), i));
      if (processors.empty()) continue;
      const int processor = processors[static_cast<std::size_t>(i) % processors.size()];
      pinned_ += pin_thread(workers_.back()->thread(), processor) ? 1 : 0;
    }
  } catch (const std::system_error& error) {
    throw Error("thread " + std::to_string(workers_.size()) + " of " +
                std::to_string(options.worlds) + " cannot be made: " + error.what() +
                "; take fewer worlds, or VecEnv");
  }
}

SimulationPool::~SimulationPool() = default;

void SimulationPool::close() { workers_.clear(); }

void SimulationPool::check(std::span<const int> worlds) const {
  if (closed()) throw Error("this pool of simulations is closed: make a new one");
  check_indices("world", worlds, size());
}

Simulation& SimulationPool::world(int index) {
  check({&index, 1});
  return workers_[static_cast<std::size_t>(index)]->simulation();
}

void SimulationPool::run(std::span<const int> worlds, const Work& work) {
  check(worlds);
  for (const int i : worlds) workers_[static_cast<std::size_t>(i)]->begin(work);
  int first = size();
  std::exception_ptr failure;
  for (const int i : worlds) {
    const std::exception_ptr thrown = workers_[static_cast<std::size_t>(i)]->finish();
    if (thrown && i < first) {
      first = i;
      failure = thrown;
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

namespace {

/// Row of each world, by its number.
std::vector<std::size_t> rows_of(std::span<const int> worlds, int size) {
  std::vector<std::size_t> row(static_cast<std::size_t>(size));
  for (std::size_t k = 0; k < worlds.size(); ++k) row[static_cast<std::size_t>(worlds[k])] = k;
  return row;
}

}  // namespace

void SimulationPool::step(std::span<const int> worlds, std::span<const float> actions) {
  check(worlds);
  const int width = environment_->action_size();
  check_values("actions", actions.size(), worlds.size(), width);
  const auto row = rows_of(worlds, size());
  const auto count = static_cast<std::size_t>(width);
  run(worlds, [&](Simulation& world, int i) {
    world.step(actions.subspan(row[static_cast<std::size_t>(i)] * count, count));
  });
}

void SimulationPool::command(std::span<const int> worlds, const std::string& robot,
                             std::span<const double> values) {
  check(worlds);
  if (worlds.empty()) return;
  const auto simulation = [this](int i) -> Simulation& {
    return workers_[static_cast<std::size_t>(i)]->simulation();
  };
  const int width = simulation(worlds.front()).command_size(robot);
  check_values("values", values.size(), worlds.size(), width);
  const auto count = static_cast<std::size_t>(width);
  for (std::size_t k = 0; k < worlds.size(); ++k) {
    try {  // too little work for a thread
      simulation(worlds[k]).command(robot, values.subspan(k * count, count));
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

}  // namespace skybody
