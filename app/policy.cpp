#include "app/policy.h"

#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "core/assemble/hold_policy.h"
#include "core/assemble/network_policy.h"
#include "core/base/random.h"
#include "core/io/flight_log.h"
#include "core/io/text.h"

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

class Network : public Policy {
 public:
  Network(const std::string& path, const Environment& environment) : policy_(path) {
    const std::string warning = policy_.check_fits(environment);
    if (!warning.empty()) spdlog::warn(warning);
  }

  void act(const Simulation& simulation, std::span<float> action) override {
    policy_.act(simulation.observation(), action);
  }

 private:
  NetworkPolicy policy_;
};

bool is_baseline(const std::string& name) {
  return std::count(policy_names().begin(), policy_names().end(), name) > 0;
}

}  // namespace

const std::vector<std::string>& policy_names() {
  static const std::vector<std::string> names = {"zero", "random", "hold"};
  return names;
}

CLI::Validator policy_argument() {
  const auto check = [](const std::string& text) -> std::string {
    std::error_code ignored;
    if (is_baseline(text) || std::filesystem::exists(text, ignored)) return "";
    const std::string near = closest(text, policy_names());
    return "there is no policy or file `" + text + "`" +
           (near.empty() ? "" : "; did you mean `" + near + "`?") +
           "; allowed: " + join(policy_names()) + ", a policy.h5, or a folder with checkpoints";
  };
  return {check, "", "policy"};
}

std::unique_ptr<Policy> make_policy(const std::string& name, const Environment& environment,
                                    std::uint64_t seed) {
  if (name == "zero") return std::make_unique<ZeroPolicy>();
  if (name == "random") return std::make_unique<RandomPolicy>(seed);
  if (name == "hold") return std::make_unique<Hold>(environment);
  skip_hdf5_cleanup_at_exit();
  return std::make_unique<Network>(name, environment);
}

}  // namespace skybody
