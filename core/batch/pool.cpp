#include "core/batch/pool.h"

#include <unistd.h>

#include <string>

#include "core/base/math/hash.h"
#include "core/base/simd/fp_environment.h"
#include "core/base/system/arguments.h"
#include "core/base/system/error.h"
#include "core/batch/scheduler.h"

namespace skybody {
namespace {

std::uint64_t checksum(std::span<const std::uint64_t> words) {
  return hash_bytes(words.data(), words.size_bytes());
}

constexpr double kMiB = 1 << 20;

double memory_of_machine() {
  return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
}

/// Refuses images beyond the machine's memory: those of every environment, and of one batch.
/// Without this, the system ends the process while it fills them.
void check_images(const CompiledScenario& compiled, int envs) {
  const double each = 8.0 * static_cast<double>(compiled.model().image_words);
  const double needed = 2.0 * each * envs, present = memory_of_machine();
  if (needed <= present) return;
  const auto whole = [](double bytes) { return std::to_string(static_cast<long>(bytes / kMiB)); };
  throw Error(std::to_string(envs) + " environments with images of " + whole(each) +
              " MiB each need " + whole(needed) + " MiB, and this machine has " + whole(present) +
              " MiB: take fewer environments or smaller images");
}

const PoolOptions& checked(const CompiledScenario& compiled, const PoolOptions& options) {
  check_range("number of environments", options.envs, 1, kMostEnvs, "take at least one");
  check_range("batch", options.batch, 0, options.envs,
              "take at most the number of environments, or 0 for all of them");
  check_range("threads", options.threads, 0, kMostThreads, "take 0 for one per processor");
  check_images(compiled, options.envs);
  return options;
}

}  // namespace

Pool::Pool(std::shared_ptr<const CompiledScenario> compiled, const PoolOptions& options)
    : scheduler_(std::make_unique<Scheduler>(compiled, checked(*compiled, options))) {}

/// A forked child has no worker threads to join, and a lock may be held by a thread that does not
/// exist there. Nothing can be destroyed safely, so the scheduler is leaked until the end of the
/// process.
Pool::~Pool() {
  if (!scheduler_->of_this_process()) static_cast<void>(scheduler_.release());
}

const CompiledScenario& Pool::compiled() const { return scheduler_->states.compiled(); }
const std::shared_ptr<const CompiledScenario>& Pool::shared_scenario() const {
  return scheduler_->states.shared_scenario();
}
int Pool::envs() const { return scheduler_->options.envs; }
int Pool::batch() const { return scheduler_->options.batch; }
int Pool::lanes() const { return scheduler_->states.places().span; }
int Pool::threads() const { return scheduler_->options.threads; }
int Pool::pinned_threads() const { return scheduler_->threads().pinned(); }
const PoolOptions& Pool::options() const { return scheduler_->options; }
bool Pool::broken() const { return scheduler_->threads().failed(); }
int Pool::in_flight() const { return scheduler_->in_flight_count; }
std::uint64_t Pool::fresh_buffers() const { return scheduler_->fresh_buffers(); }
std::uint64_t Pool::faults() const { return scheduler_->faults; }

void Pool::send_reset() {
  const std::vector<std::uint8_t> all(static_cast<std::size_t>(envs()), 1);
  send_reset(all);
}

void Pool::send_reset(std::span<const std::uint8_t> mask) {
  check_values("mask", mask.size(), 1, envs());
  scheduler_->send_reset(mask);
  if (scheduler_->observer) scheduler_->observer->reset_sent(mask);
}

void Pool::send_reset(std::uint64_t seed) {
  scheduler_->send_reset(seed);
  if (scheduler_->observer) scheduler_->observer->reseeded(seed);
}

void Pool::send(std::span<const float> actions, std::span<const std::int32_t> env_ids) {
  scheduler_->send_steps(actions, env_ids);
  if (scheduler_->observer) scheduler_->observer->actions_sent(actions, env_ids);
}

std::shared_ptr<const Batch> Pool::recv() {
  return scheduler_->recv(ThreadPool::Clock::time_point::max());
}

std::shared_ptr<const Batch> Pool::recv(std::chrono::milliseconds patience) {
  constexpr std::chrono::hours kForEver{24 * 365 * 100};  // later times overflow the clock
  if (patience >= kForEver) return recv();
  return scheduler_->recv(ThreadPool::Clock::now() + patience);
}

std::vector<std::uint64_t> Pool::save() const {
  scheduler_->check_idle("save()");
  std::vector<std::uint64_t> saved = scheduler_->states.save();
  saved.push_back(static_cast<std::uint64_t>(scheduler_->cursor));
  saved.push_back(checksum(saved));
  return saved;
}

void Pool::restore(std::span<const std::uint64_t> saved) {
  scheduler_->check_idle("restore()");
  if (saved.size() < 2) throw Error("this is not a saved state: it is empty");
  const auto content = saved.first(saved.size() - 1);
  const auto environments = content.first(content.size() - 1);
  scheduler_->states.check_saved(environments);
  if (saved.back() != checksum(content)) {
    throw Error(
        "this saved state was changed after save() gave it (its checksum is another): restore an "
        "unchanged one");
  }
  scheduler_->states.restore(environments);
  scheduler_->cursor = static_cast<int>(content.back() % static_cast<std::uint64_t>(envs()));
  if (scheduler_->observer) scheduler_->observer->restored(saved);
}

void Pool::fork(int source, std::span<const std::int32_t> targets, bool rekey) {
  scheduler_->check_alive();
  const auto check = [&](std::int32_t env) {
    scheduler_->check_id(env);
    if (scheduler_->in_flight(env)) {
      throw Error("fork() with environment " + std::to_string(env) + " in flight: recv() it first");
    }
  };
  check(source);
  for (const std::int32_t target : targets) check(target);
  scheduler_->settle(source);
  for (const std::int32_t target : targets) scheduler_->settle(target);
  for (const std::int32_t target : targets) scheduler_->states.fork(source, target, rekey);
  if (scheduler_->observer) scheduler_->observer->forked(source, targets, rekey);
}

void Pool::observations(std::span<float> observation) const {
  scheduler_->check_idle("observations()");
  const FpEnvironment guard;
  const int width = compiled().observation_size();
  check_values("observation", observation.size(), static_cast<std::size_t>(envs()), width);
  for (int env = 0; env < envs(); ++env) {
    scheduler_->states.observation(env,
                                   observation.data() + static_cast<std::ptrdiff_t>(env) * width);
  }
}

void Pool::privileged(std::span<float> privileged) const {
  scheduler_->check_idle("privileged()");
  const FpEnvironment guard;
  const int width = compiled().privileged_size();
  check_values("privileged", privileged.size(), static_cast<std::size_t>(envs()), width);
  for (int env = 0; env < envs(); ++env) {
    scheduler_->states.privileged(env,
                                  privileged.data() + static_cast<std::ptrdiff_t>(env) * width);
  }
}

void Pool::image(int image, std::span<std::uint8_t> pixels) const {
  scheduler_->check_idle("image()");
  check_index("image", image, static_cast<int>(compiled().images().size()));
  const int width = compiled().images()[static_cast<std::size_t>(image)].bytes;
  check_values("pixels", pixels.size(), static_cast<std::size_t>(envs()), width);
  for (int env = 0; env < envs(); ++env) {
    scheduler_->states.image(env, image, pixels.data() + static_cast<std::ptrdiff_t>(env) * width);
  }
}

void Pool::state(std::string_view path, std::span<double> values) const {
  scheduler_->check_idle("state()");
  const StateValue& value = compiled().state_values().at(path);
  check_values("values", values.size(), static_cast<std::size_t>(envs()), value.count());
  for (int env = 0; env < envs(); ++env) check_started("state()", env);
  const FpEnvironment guard;
  scheduler_->states.state(value, values.data());
}

std::vector<double> Pool::goals(int env) const {
  scheduler_->check_idle("goals()");
  scheduler_->check_id(env);
  check_started("goals()", env);
  std::vector<double> found;
  scheduler_->states.goals(env, found);
  return found;
}

/// @param call  for the message
void Pool::check_started(const char* call, int env) const {
  if (scheduler_->states.flags().started(env)) return;
  throw Error(std::string(call) + " of environment " + std::to_string(env) +
              ", which has not begun an episode: reset it first");
}

double Pool::param(int env, const std::string& path) const {
  scheduler_->check_idle("param()");
  scheduler_->check_id(env);
  return scheduler_->states.param(env, path);
}

void Pool::set_param(int env, const std::string& path, double value) {
  scheduler_->check_idle("set_param()");
  scheduler_->check_id(env);
  scheduler_->states.set_param(env, path, value);
  if (scheduler_->observer) scheduler_->observer->param_set(env, path, value);
}

void Pool::request(std::span<const ParamChange> changes, RequestTime when,
                   std::span<const std::int32_t> env_ids) {
  ask({changes, false, when, env_ids});
}

void Pool::randomize(RequestTime when, std::span<const std::int32_t> env_ids) {
  ask({{}, true, when, env_ids});
}

void Pool::ask(const PoolRequest& asked) {
  scheduler_->check_alive();
  for (const std::int32_t env : asked.env_ids) scheduler_->check_id(env);
  const auto request =
      std::make_shared<const ParamRequest>(compiled(), asked.changes, asked.redraws);
  const bool at_reset = asked.when == RequestTime::kNextReset;
  for (const std::int32_t env : asked.env_ids)
    scheduler_->states.requests().ask(env, request, at_reset);
  for (int env = 0; asked.env_ids.empty() && env < envs(); ++env) {
    scheduler_->states.requests().ask(env, request, at_reset);
  }
  if (scheduler_->observer) scheduler_->observer->requested(asked);
}

StepCounts Pool::step_counts() const {
  scheduler_->check_idle("step_counts()");
  return scheduler_->states.step_counts();
}

std::uint64_t Pool::hash(int env) const {
  scheduler_->check_idle("hash()");
  scheduler_->check_id(env);
  if (!scheduler_->options.keep_hash && !scheduler_->observer) {
    throw StateError("no hash was kept: make the Pool with keep_hash");
  }
  return scheduler_->states.hash(env);
}

std::uint64_t Pool::hash() const {
  HashChain all;
  for (int env = 0; env < envs(); ++env) all.update(hash(env));
  return all.value();
}

void Pool::observe(std::shared_ptr<PoolObserver> observer) {
  if (observer) scheduler_->check_idle("observe()");
  scheduler_->observer = std::move(observer);
  scheduler_->states.keep_hash(scheduler_->options.keep_hash || scheduler_->observer != nullptr);
}

}  // namespace skybody
