#include "python/native/remote_slices.h"

#include <nanobind/stl/string.h>

#include <algorithm>
#include <string>
#include <utility>

#include "python/native/arrays.h"

namespace skybody::python {
namespace {

template <class T>
void read(nb::handle array, const char* name, std::vector<T>& to, std::int64_t count = -1) {
  const Values<T> values = read_array<T>(array, name, {count});
  to.assign(values.span().begin(), values.span().end());
}

/// Prefix of the blocks of slice 3: "slice3.".
std::string prefix_of(int slice) { return "slice" + std::to_string(slice) + "."; }

}  // namespace

nb::tuple state_of(const learn::StateBlocks& blocks, std::span<const std::uint64_t> environments) {
  nb::dict named;
  for (const auto& [name, words] : blocks) named[name.c_str()] = array_of<std::uint64_t>(words);
  return nb::make_tuple(named, array_of<std::uint64_t>(environments));
}

std::vector<std::uint64_t> read_state(nb::handle state, learn::StateBlocks& blocks) {
  const nb::tuple parts = nb::cast<nb::tuple>(state);
  for (const auto [name, words] : nb::cast<nb::dict>(parts[0])) {
    auto& block = blocks.emplace_back(nb::cast<std::string>(name), std::vector<std::uint64_t>());
    read(words, "a block of a slice", block.second);
  }
  std::vector<std::uint64_t> environments;
  read(parts[1], "a slice's environments", environments);
  return environments;
}

RemoteSlices::RemoteSlices(nb::object holder, int count)
    : holder_(std::move(holder)),
      outputs_(static_cast<std::size_t>(count)),
      saved_(nb::none()),
      restored_() {}

RemoteSlices::~RemoteSlices() {
  const nb::gil_scoped_acquire gil;
  holder_.reset();
  saved_.reset();
  restored_.reset();
}

void RemoteSlices::collect(const learn::RolloutInputs& inputs, const learn::PpoNetworks& networks) {
  const nb::gil_scoped_acquire gil;
  saved_ = nb::none();
  const auto found = calling([&] {
    return holder_.attr("collect")(array_of(networks.policy_parameters()),
                                   array_of(networks.value_parameters()), inputs.iteration,
                                   array_of<double>(inputs.mean), array_of<double>(inputs.scale),
                                   inputs.return_mean);
  });
  const auto sums = static_cast<std::int64_t>(learn::kRolloutSums + 2 * inputs.mean.size());
  for (std::size_t k = 0; k < outputs_.size(); ++k) {
    const nb::tuple slice = nb::cast<nb::tuple>(nb::object(found[k]));
    read(slice[0], "sums of a rollout", outputs_[k].rollout_sums, sums);
    read(slice[1], "returns of episodes", outputs_[k].episode_returns);
  }
}

void RemoteSlices::find_advantages(double reward_scale, const learn::PpoNetworks&) {
  const nb::gil_scoped_acquire gil;
  const auto found = calling([&] { return holder_.attr("find_advantages")(reward_scale); });
  for (std::size_t k = 0; k < outputs_.size(); ++k) {
    read(nb::object(found[k]), "sums of advantages", outputs_[k].advantage_sums,
         learn::kAdvantageSums);
  }
}

void RemoteSlices::find_gradients(const learn::Minibatch& minibatch,
                                  const learn::PpoNetworks& networks) {
  const nb::gil_scoped_acquire gil;
  const auto found = calling([&] {
    return holder_.attr("find_gradients")(array_of(networks.policy_parameters()),
                                          array_of(networks.value_parameters()), minibatch.epoch,
                                          minibatch.index, minibatch.policy, minibatch.value,
                                          minibatch.advantage_mean, minibatch.advantage_scale);
  });
  const auto wanted = [](bool is_wanted, std::span<const float> parameters) {
    return is_wanted ? static_cast<std::int64_t>(parameters.size()) : std::int64_t{0};
  };
  const std::int64_t policy = wanted(minibatch.policy, networks.policy_parameters());
  const std::int64_t value = wanted(minibatch.value, networks.value_parameters());
  for (std::size_t k = 0; k < outputs_.size(); ++k) {
    const nb::tuple slice = nb::cast<nb::tuple>(nb::object(found[k]));
    read(slice[0], "sums of a minibatch", outputs_[k].minibatch_sums, learn::kMinibatchSums);
    read(slice[1], "a gradient of the policy", outputs_[k].policy_gradient, policy);
    read(slice[2], "a gradient of the value function", outputs_[k].value_gradient, value);
  }
}

void RemoteSlices::stagger_resets(std::int64_t iteration) {
  const nb::gil_scoped_acquire gil;
  saved_ = nb::none();
  calling([&] { holder_.attr("stagger_resets")(iteration); });
}

learn::SliceOutputs RemoteSlices::outputs(int k) const {
  const Outputs& of = outputs_[static_cast<std::size_t>(k)];
  return {of.rollout_sums,    of.advantage_sums, of.minibatch_sums,
          of.policy_gradient, of.value_gradient, of.episode_returns};
}

/// One call of save() serves all slices.
std::vector<std::uint64_t> RemoteSlices::save(int k, learn::StateBlocks& blocks) const {
  const nb::gil_scoped_acquire gil;
  if (saved_.is_none()) saved_ = calling([&] { return nb::object(holder_.attr("save")()); });
  return read_state(nb::object(saved_[k]), blocks);
}

/// Checks that there are blocks; the worker checks their sizes.
void RemoteSlices::check(int k, const learn::StateBlocks& blocks) {
  const std::string prefix = prefix_of(k);
  const bool is_there = std::any_of(blocks.begin(), blocks.end(), [&](const auto& block) {
    return block.first.starts_with(prefix);
  });
  if (!is_there) throw Error("the checkpoint has no `" + prefix + "...`: it is another learner's");
}

/// One call of restore() for all slices, with the last one.
void RemoteSlices::restore(int k, const learn::StateBlocks& blocks,
                           std::span<const std::uint64_t> environments) {
  const nb::gil_scoped_acquire gil;
  learn::StateBlocks own;
  for (const auto& block : blocks) {
    if (block.first.starts_with(prefix_of(k))) own.push_back(block);
  }
  if (k == 0) restored_ = nb::list();
  restored_.append(state_of(own, environments));
  if (k + 1 < count()) return;
  saved_ = nb::none();
  calling([&] { holder_.attr("restore")(restored_); });
  restored_ = nb::list();
}

}  // namespace skybody::python
