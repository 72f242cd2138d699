// Saved states. The first byte of an input names a scenario. The second byte tells how the words
// after it are used:
// - `.`: they go to restore() as they are
// - `!`: they become environment 1's words in an otherwise valid state with a valid checksum, as
//   anyone
//   can write who makes states by hand
#include <cstring>

#include "core/base/math/hash.h"
#include "core/simulation/simulation.h"
#include "tests/fuzz/areas.h"
#include "tests/fuzz/batch_rows.h"
#include "tests/fuzz/flight_check.h"
#include "tests/fuzz/plugin_source.h"

namespace skybody::fuzz {
namespace {

constexpr int kEnvs = 4, kChanged = 1;
constexpr int kSteps = 3;
constexpr std::size_t kPrefix = 2;
const char* const kScenarios[] = {"hover", "payload", "collision"};

using Words = std::vector<std::uint64_t>;

PoolOptions batch_options() {
  PoolOptions options;
  options.envs = kEnvs;
  options.threads = 1;
  options.seed = 3;
  return options;
}

BatchRows receive_all(Pool& envs) { return BatchRows::receive(envs, Faults::kAreAnything); }

/// A batch that is restored repeatedly.
class Flock {
 public:
  explicit Flock(std::shared_ptr<const CompiledScenario> compiled)
      : envs_(std::move(compiled), batch_options()),
        actions_(static_cast<std::size_t>(kEnvs * envs_.compiled().action_size()), 0.2f) {}

  /// Output of save() after a few steps.
  Words saved() {
    envs_.send_reset();
    receive_all(envs_);
    for (int k = 0; k < kSteps; ++k) step();
    return envs_.save();
  }

  std::vector<BatchRows> fly(const Words& words) {
    envs_.restore(words);
    std::vector<BatchRows> rows;
    for (int k = 0; k < kSteps; ++k) rows.push_back(step());
    const std::vector<std::uint8_t> mask = {0, 1, 0, 0};
    envs_.send_reset(mask);
    receive_all(envs_);
    rows.push_back(step());
    return rows;
  }

 private:
  BatchRows step() {
    envs_.send(actions_);
    return receive_all(envs_);
  }

  Pool envs_;
  std::vector<float> actions_;
};

/// One scenario's environments, and their transitions from the unchanged state.
struct Stage {
  std::shared_ptr<const CompiledScenario> compiled;
  Words saved;
  std::unique_ptr<Flock> flock;  ///< of this process
  std::vector<BatchRows> expected;
};

Words words_of(const std::string& input) {
  Words words((input.size() - kPrefix) / sizeof(std::uint64_t));
  std::memcpy(words.data(), input.data() + kPrefix, words.size() * sizeof(std::uint64_t));
  return words;
}

class StateArea : public Area {
 public:
  StateArea() {
    for (const char* name : kScenarios) {
      Diagnostics diagnostics;
      LoadOptions options;
      options.scenario = name;
      Stage stage;
      stage.compiled = compile_scenario(options, shipped_plugins(), diagnostics);
      diagnostics.throw_if_errors();
      stage.saved = Flock(stage.compiled).saved();
      for (const char kind : {'.', '!', '!', '!'}) add_seed(name[0], kind, stage.saved);
      stages_.push_back(std::move(stage));
    }
    material_.words = {std::string("\0\0\0\0\0\0\xf8\x7f", 8), std::string(8, '\xff')};
  }

  void begin(const std::filesystem::path&) override {
    for (Stage& stage : stages_) {
      stage.flock = std::make_unique<Flock>(stage.compiled);
      stage.expected = stage.flock->fly(stage.saved);
    }
  }

  Answer run(const std::string& input, bool) override {
    if (input.size() < kPrefix) return Answer::kRefused;
    Stage& stage = stage_of(input[0]);
    const Words words = words_of(input);
    try {
      return input[1] == '.' ? restore_as_they_are(stage, words) : restore_one(stage, words);
    } catch (const Error& error) {
      check_message(error.what());
      return Answer::kRefused;
    }
  }

  std::size_t smallest_leak() const override { return kSmallLeak; }

 private:
  void add_seed(char scenario, char kind, const Words& words) {
    std::string seed = {scenario, kind};
    seed.append(reinterpret_cast<const char*>(words.data()), words.size() * sizeof(std::uint64_t));
    material_.seeds.push_back(std::move(seed));
  }

  Stage& stage_of(char name) {
    for (std::size_t k = 0; k < stages_.size(); ++k) {
      if (kScenarios[k][0] == name) return stages_[k];
    }
    return stages_[0];
  }

  static Answer restore_as_they_are(Stage& stage, const Words& words) {
    stage.flock->fly(words);
    if (words != stage.saved) silent_change("a state was restored that save() did not give");
    return Answer::kAccepted;
  }

  static Answer restore_one(Stage& stage, const Words& words) {
    const auto size = static_cast<std::size_t>(stage.compiled->layout().words);
    const std::size_t each =
        (stage.saved.size() - 7) / kEnvs;  // 5 words precede the environments' words, 2 follow them
    const std::size_t first = 5 + kChanged * each;
    Words changed = stage.saved;
    for (std::size_t k = first; k < std::min(first + each, words.size()); ++k) {
      changed[k] = words[k];
    }
    changed.back() = hash_bytes(changed.data(), (changed.size() - 1) * sizeof(std::uint64_t));
    const std::vector<BatchRows> rows = stage.flock->fly(changed);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      check_others(rows[k], stage.expected[k], kEnvs, kChanged);
    }
    const auto begin = changed.begin() + static_cast<std::ptrdiff_t>(first);
    fly_alone(stage, {begin, begin + static_cast<std::ptrdiff_t>(size)});
    return Answer::kAccepted;
  }

  static void fly_alone(const Stage& stage, Words words) {
    Simulation simulation(stage.compiled, 1, 0);
    simulation.reset();
    Snapshot snapshot = simulation.save();
    snapshot.words = std::move(words);
    simulation.restore(snapshot);
    const std::vector<float> action(static_cast<std::size_t>(simulation.action_size()), 0.2f);
    for (int k = 0; k < kSteps; ++k) {
      simulation.step(action);
      check_rows(simulation, Faults::kAreAnything);
    }
    simulation.fork(true).reset();
    simulation.reset();
    check_rows(simulation, Faults::kAreAnything);
  }

  std::vector<Stage> stages_;
};

}  // namespace

std::unique_ptr<Area> make_state_area(const AreaOptions&) { return std::make_unique<StateArea>(); }

}  // namespace skybody::fuzz
