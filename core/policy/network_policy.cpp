#include "core/policy/network_policy.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/base/math/hash.h"
#include "core/base/simd/fp_environment.h"
#include "core/base/system/error.h"
#include "core/policy/network_layers.h"

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
    : file_(find_policy(path)), policy_(read_policy(file_)) {
  prepare();
}

NetworkPolicy::NetworkPolicy(PolicyFile policy) : policy_(std::move(policy)) { prepare(); }

void NetworkPolicy::prepare() {
  int width = policy_.input_size() + policy_.feature_size();
  for (const PolicyImage& image : policy_.images) image_features_.emplace_back(image);
  views_.resize(policy_.images.size());
  features_.resize(static_cast<std::size_t>(policy_.feature_size()));
  for (const PolicyLayer& layer : policy_.layers) width = std::max(width, layer.outputs);
  values_.resize(static_cast<std::size_t>(width));
  next_.resize(values_.size());
  normalization_ = NormalizationWeights(policy_);
  std::size_t sums = 0;
  for (const PolicyLayer& layer : policy_.layers) {
    weights_.emplace_back(layer);
    if (!layer.is_recurrent()) continue;
    state_size_ += layer.state_size();
    sums = std::max(sums, 2 * layer.bias.size());
  }
  sums_.resize(sums);
  reset();
  if (!policy_.agents.empty()) return;
  all_.observation.resize(static_cast<std::size_t>(policy_.observation_size));
  all_.action.resize(static_cast<std::size_t>(policy_.action_size));
  std::iota(all_.observation.begin(), all_.observation.end(), 0);
  std::iota(all_.action.begin(), all_.action.end(), 0);
}

std::string NetworkPolicy::check_fits(const CompiledScenario& compiled) const {
  const Scenario& scenario = compiled.scenario();
  const bool is_named = !policy_.scenario.empty();
  const std::string trained = is_named ? "`" + policy_.scenario + "`" : "another scenario";
  const std::string subject = "the policy " + file_.string() + " was trained on " + trained;
  const std::string sizes = sizes_text(policy_.observation_size, policy_.action_size);
  if (policy_.observation_size != compiled.observation_size() ||
      policy_.action_size != compiled.action_size()) {
    throw Error(subject + " with " + sizes + "; `" + scenario.name + "` has " +
                sizes_text(compiled.observation_size(), compiled.action_size()) + ": fly it in " +
                (is_named ? trained : "the scenario that it was trained on"));
  }
  for (const PolicyImage& image : policy_.images) check_image(image, file_, compiled);
  if (policy_.scenario_hash == to_hex(scenario.hash)) return "";
  if (policy_.scenario == scenario.name) {
    return subject +
           ", whose values have changed since: observations and actions have the same "
           "size, their meaning and the flight may differ";
  }
  return subject + ", and flies `" + scenario.name + "`: both have " + sizes +
         ", their meaning and the flight may differ";
}

void NetworkPolicy::reset() {
  const std::size_t robots = std::max<std::size_t>(1, policy_.agents.size());
  own_.states.assign(robots * static_cast<std::size_t>(state_size_), 0.0f);
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
    const ObservationColumn* column = column_of(policy_.images[k], simulation.compiled());
    SKYBODY_DEMAND(column != nullptr, "a policy flies a scenario that it fits");
    views_[k] = {column->type, simulation.image(column->image).data()};
  }
  act(simulation.observation(), views_, state_size_ > 0 ? memory_of(simulation) : own_, action);
}

void NetworkPolicy::act(std::span<const float> observation, std::span<float> action,
                        std::span<const ImageView> images) {
  act(observation, images, own_, action);
}

void NetworkPolicy::act(std::span<const float> observation, std::span<const ImageView> images,
                        Memory& memory, std::span<float> action) {
  SKYBODY_DEMAND(static_cast<int>(observation.size()) == policy_.observation_size &&
                     static_cast<int>(action.size()) == policy_.action_size &&
                     images.size() == policy_.images.size(),
                 "a policy's rows have the wrong width");
  const FpEnvironment guard;
  float* feature = features_.data();
  for (std::size_t k = 0; k < images.size(); ++k) {
    image_features_[k].evaluate(images[k].type, images[k].pixels, feature);
    feature += image_features_[k].features();
  }
  float* states = memory.states.data();
  if (policy_.agents.empty()) {
    act(all_, observation, states, action);
  } else {
    for (const PolicyAgent& agent : policy_.agents) {
      act(agent, observation, states, action);
      states += state_size_;
    }
  }
}

/// From values_ to next_.
void NetworkPolicy::evaluate(std::size_t index, float* state) {
  const PolicyLayer& layer = policy_.layers[index];
  const LayerWeights& w = weights_[index];
  if (layer.is_recurrent()) {
    const auto advance = layer.kind == LayerKind::kGru ? layer_gru : layer_lstm;
    advance(w.weight.data(), w.bias.data(), w.state_weight.data(), w.state_bias.data(),
            layer.inputs, layer.outputs, values_.data(), state, sums_.data());
    std::copy_n(state, layer.outputs, next_.data());
  } else {
    layer_dense(w.weight.data(), w.bias.data(), layer.inputs, layer.outputs,
                static_cast<int>(layer.activation), values_.data(), next_.data());
  }
}

void NetworkPolicy::act(const PolicyAgent& agent, std::span<const float> observation, float* states,
                        std::span<float> action) {
  for (std::size_t k = 0; k < agent.observation.size(); ++k) {
    values_[k] = observation[static_cast<std::size_t>(agent.observation[k])];
  }
  const NormalizationWeights& n = normalization_;
  if (!n.mean.empty()) {
    layer_normalize(values_.data(), n.mean.data(), n.mean_rest.data(), n.scale.data(), n.clip,
                    static_cast<int>(n.mean.size()), values_.data());
  }
  std::copy(features_.begin(), features_.end(),
            values_.begin() + static_cast<std::ptrdiff_t>(agent.observation.size()));
  for (std::size_t k = 0; k < policy_.layers.size(); ++k) {
    evaluate(k, states);
    states += policy_.layers[k].state_size();
    values_.swap(next_);
  }
  for (std::size_t k = 0; k < agent.action.size(); ++k) {
    const float value = policy_.squash == ActionSquash::kTanh ? layer_tanh(values_[k]) : values_[k];
    action[static_cast<std::size_t>(agent.action[k])] = clip_action(static_cast<double>(value));
  }
}

}  // namespace skybody
