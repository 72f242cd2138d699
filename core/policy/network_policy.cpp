#include "core/policy/network_policy.h"

#include <algorithm>
#include <utility>

#include "core/base/math/hash.h"
#include "core/base/simd/fp_environment.h"
#include "core/base/system/error.h"

namespace skybody {
namespace {

std::string sizes_text(int observations, int actions) {
  return std::to_string(observations) + (observations == 1 ? " observation" : " observations") +
         " and " + std::to_string(actions) + (actions == 1 ? " action" : " actions");
}

/// The scenario's column of an image, or null.
const ObservationColumn* column_of(const PolicyImage& image, const CompiledScenario& compiled) {
  for (const ObservationColumn& column : compiled.columns()) {
    if (column.image >= 0 && column.name == image.column) return &column;
  }
  return nullptr;
}

void check_image(const PolicyImage& image, const std::filesystem::path& file,
                 const CompiledScenario& compiled) {
  const std::string who = "the policy " + file.string() + " sees `" + image.column + "` of " +
                          std::to_string(image.height) + " x " + std::to_string(image.width) +
                          " x " + std::to_string(image.channels) + " values; ";
  const ObservationColumn* column = column_of(image, compiled);
  if (column == nullptr) {
    throw Error(who + compiled.scenario().file +
                " observes no such image: fly it in the scenario that it was trained on");
  }
  std::vector<int> shape = column->shape;
  if (shape.size() == 2) shape.push_back(1);
  if (shape == std::vector<int>{image.height, image.width, image.channels}) return;
  std::string extents;
  for (const int extent : column->shape)
    extents += (extents.empty() ? "" : " x ") + std::to_string(extent);
  throw Error(who + compiled.scenario().file + " has " + extents +
              ": fly it in the scenario that it was trained on");
}

}  // namespace

NetworkPolicy::NetworkPolicy(const std::filesystem::path& path)
    : NetworkPolicy(read_policy(find_policy(path))) {
  file_ = find_policy(path);
}

NetworkPolicy::NetworkPolicy(PolicyFile policy) : network_(std::move(policy)) {
  views_.resize(this->policy().images.size());
  reset();
}

std::string NetworkPolicy::check_fits(const CompiledScenario& compiled) const {
  const Scenario& scenario = compiled.scenario();
  const bool is_named = !policy().scenario.empty();
  const std::string trained = is_named ? "`" + policy().scenario + "`" : "another scenario";
  const std::string subject = "the policy " + file_.string() + " was trained on " + trained;
  const std::string sizes = sizes_text(policy().observation_size, policy().action_size);
  if (policy().observation_size != compiled.observation_size() ||
      policy().action_size != compiled.action_size()) {
    throw Error(subject + " with " + sizes + "; `" + scenario.name + "` has " +
                sizes_text(compiled.observation_size(), compiled.action_size()) + ": fly it in " +
                (is_named ? trained : "the scenario that it was trained on"));
  }
  for (const PolicyImage& image : policy().images) check_image(image, file_, compiled);
  if (policy().scenario_hash == to_hex(scenario.hash)) return "";
  if (policy().scenario == scenario.name) {
    return subject +
           ", whose values have changed since: observations and actions have the same "
           "size, their meaning and the flight may differ";
  }
  return subject + ", and flies `" + scenario.name + "`: both have " + sizes +
         ", their meaning and the flight may differ";
}

void NetworkPolicy::reset() {
  own_.states.assign(network_.agents().size() * static_cast<std::size_t>(network_.state_size()),
                     0.0f);
}

/// The network's memory of a simulation's episode, empty in its first step.
NetworkPolicy::Memory& NetworkPolicy::memory_of(const Simulation& simulation) {
  auto memory = std::find_if(memories_.begin(), memories_.end(),
                             [&](const Memory& m) { return m.simulation == &simulation; });
  if (memory == memories_.end()) {
    memories_.push_back({&simulation, std::vector<float>(own_.states.size())});
    memory = memories_.end() - 1;
  }
  if (simulation.steps() == 0) std::fill(memory->states.begin(), memory->states.end(), 0.0f);
  return *memory;
}

void NetworkPolicy::act(const Simulation& simulation, std::span<float> action) {
  for (std::size_t k = 0; k < views_.size(); ++k) {
    const ObservationColumn* column = column_of(policy().images[k], simulation.compiled());
    SKYBODY_DEMAND(column != nullptr, "a policy flies a scenario that it fits");
    views_[k] = {column->type, simulation.image(column->image).data()};
  }
  act(simulation.observation(), views_, network_.state_size() > 0 ? memory_of(simulation) : own_,
      action);
}

void NetworkPolicy::act(std::span<const float> observation, std::span<float> action,
                        std::span<const ImageView> images) {
  act(observation, images, own_, action);
}

void NetworkPolicy::act(std::span<const float> observation, std::span<const ImageView> images,
                        Memory& memory, std::span<float> action) {
  SKYBODY_DEMAND(static_cast<int>(observation.size()) == policy().observation_size &&
                     static_cast<int>(action.size()) == policy().action_size &&
                     images.size() == policy().images.size(),
                 "a policy's rows have the wrong width");
  const FpEnvironment guard;
  network_.see(images);
  float* states = memory.states.data();
  for (const PolicyAgent& agent : network_.agents()) {
    const std::span<const float> outputs = network_.evaluate(agent, observation, states);
    for (std::size_t k = 0; k < outputs.size(); ++k) {
      action[static_cast<std::size_t>(agent.action[k])] =
          clip_action(static_cast<double>(outputs[k]));
    }
    states += network_.state_size();
  }
}

}  // namespace skybody
