#include "app/policy.h"

#include <algorithm>

#include "core/assemble/hold_policy.h"
#include "core/base/random.h"

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

class Hold : public Policy {
 public:
  explicit Hold(const Environment& environment) : policy_(environment) {}

  void act(const Simulation& simulation, std::span<float> action) override {
    policy_.act(simulation, action);
  }

 private:
  HoldPolicy policy_;
};

}  // namespace

const std::vector<std::string>& policy_names() {
  static const std::vector<std::string> names = {"zero", "random", "hold"};
  return names;
}

std::unique_ptr<Policy> make_policy(const std::string& name, const Environment& environment,
                                    std::uint64_t seed) {
  if (name == "zero") return std::make_unique<ZeroPolicy>();
  if (name == "random") return std::make_unique<RandomPolicy>(seed);
  if (name == "hold") return std::make_unique<Hold>(environment);
  SKYBODY_DEMAND(false, "no policy " + name);
}
}  // namespace skybody
