#include "core/policy/policy.h"

#include <algorithm>

#include "core/base/math/random.h"
#include "core/base/system/error.h"
#include "core/io/files/shipped_files.h"
#include "core/io/files/text.h"
#include "core/policy/hold/hold_policy.h"
#include "core/policy/network_policy.h"

namespace skybody {
namespace {

/// The middle of every command's range.
class ZeroPolicy : public Policy {
 public:
  void act(const Simulation&, std::span<float> action) override {
    std::fill(action.begin(), action.end(), 0.0f);
  }
};

/// Uniform in [-1, 1]: a function of seed, episode and step alone.
class RandomPolicy : public Policy {
 public:
  explicit RandomPolicy(std::uint64_t seed) : seed_(seed) {}

  void act(const Simulation& simulation, std::span<float> action) override {
    Random<double> random(RandomKey{seed_, 0}, simulation.episode(), simulation.steps(),
                          derive_stream("policy.random"));
    for (float& value : action) value = static_cast<float>(random.uniform(-1.0, 1.0));
  }

 private:
  std::uint64_t seed_;
};

struct Baseline {
  const char* name;
  std::unique_ptr<Policy> (*make)(const CompiledScenario& compiled, std::uint64_t seed);
};

constexpr Baseline kBaselines[] = {
    {"zero",
     [](const CompiledScenario&, std::uint64_t) -> std::unique_ptr<Policy> {
       return std::make_unique<ZeroPolicy>();
     }},
    {"random",
     [](const CompiledScenario&, std::uint64_t seed) -> std::unique_ptr<Policy> {
       return std::make_unique<RandomPolicy>(seed);
     }},
    {"hold",
     [](const CompiledScenario& compiled, std::uint64_t) -> std::unique_ptr<Policy> {
       return std::make_unique<HoldPolicy>(compiled);
     }},
};

/// The user's name for a scenario: a shipped one by its name, another one by its file.
std::string asked_for(const Scenario& scenario) {
  const auto shipped = find_shipped_scenario(scenario.name);
  return shipped && shipped->string() == scenario.file ? scenario.name : scenario.file;
}

}  // namespace

const std::vector<std::string>& policy_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Baseline& baseline : kBaselines) all.emplace_back(baseline.name);
    return all;
  }();
  return names;
}

std::filesystem::path shipped_policy_file(const std::string& scenario, const std::string& trained) {
  if (const auto file = find_shipped_policy(scenario)) return *file;
  const std::vector<std::string> names = shipped_policies();
  throw Error("no policy is shipped for `" + scenario + "`" +
              (names.empty() ? "" : "; there are ones for " + join(names)) +
              ": train one with `skybody train " + trained + "` and give its folder");
}

std::unique_ptr<Policy> make_policy(const std::string& name, const CompiledScenario& compiled,
                                    std::uint64_t seed) {
  for (const Baseline& baseline : kBaselines) {
    if (name == baseline.name) return baseline.make(compiled, seed);
  }
  if (name == kShippedPolicy) {
    return std::make_unique<NetworkPolicy>(
        shipped_policy_file(compiled.scenario().name, asked_for(compiled.scenario())));
  }
  return std::make_unique<NetworkPolicy>(name);
}

}  // namespace skybody
