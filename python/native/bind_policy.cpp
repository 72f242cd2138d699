#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/system/printable.h"
#include "core/io/files/policy_checksum.h"
#include "core/io/files/policy_file.h"
#include "core/io/files/policy_writer.h"
#include "core/policy/policy.h"
#include "python/native/arrays.h"
#include "python/native/bindings.h"

namespace skybody::python {
namespace {

nb::bytes bytes_of(const std::string& text) { return nb::bytes(text.data(), text.size()); }

nb::object vector_of(const std::vector<double>& values) {
  return copy_of<double>(values, {values.size()});
}

nb::dict read_policy_file(const std::string& file) { return dict_of(read_policy(file)); }

using Numbers = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;

std::vector<double> numbers_of(nb::handle values) {
  const auto array = nb::cast<Numbers>(values);
  return {array.data(), array.data() + array.size()};
}

PolicyLayer layer_of(nb::handle values) {
  PolicyLayer layer;
  const auto weight = nb::cast<Numbers>(values[0]);
  if (weight.ndim() != 2)
    throw Error("a layer's weight has " + std::to_string(weight.ndim()) +
                " dimensions; it takes (out, in)");
  layer.weight = numbers_of(values[0]);
  layer.bias = numbers_of(values[1]);
  const auto word = nb::cast<std::string>(values[2]);
  const std::optional<Activation> activation = find_activation(word);
  if (!activation)
    throw Error("a layer's activation is `" + word + "`: take tanh, relu, elu or none");
  layer.activation = *activation;
  layer.inputs = static_cast<int>(weight.shape(1));
  layer.outputs = static_cast<int>(weight.shape(0));
  if (nb::len(values) == 3) return layer;
  if (nb::len(values) == 4) {
    layer.kind = LayerKind::kConv;
    layer.conv.outputs = layer.outputs;
    layer.conv.kernel_height = nb::cast<int>(values[3][0]);
    layer.conv.kernel_width = nb::cast<int>(values[3][1]);
    layer.conv.stride = nb::cast<int>(values[3][2]);
    layer.conv.same = nb::cast<std::string>(values[3][3]) == "same";
    return layer;
  }
  const auto state_weight = nb::cast<Numbers>(values[3]);
  const bool is_lstm =
      state_weight.ndim() == 2 && state_weight.shape(0) == 4 * state_weight.shape(1);
  layer.kind = is_lstm ? LayerKind::kLstm : LayerKind::kGru;
  layer.outputs /= layer.gates();
  layer.state_weight = numbers_of(values[3]);
  layer.state_bias = numbers_of(values[4]);
  return layer;
}

PolicyImage image_of(nb::handle values) {
  PolicyImage image;
  image.column = nb::cast<std::string>(values[0]);
  image.height = nb::cast<int>(values[1][0]);
  image.width = nb::cast<int>(values[1][1]);
  image.channels = nb::cast<int>(values[1][2]);
  image.low = nb::cast<double>(values[2]);
  image.high = nb::cast<double>(values[3]);
  for (nb::handle layer : values[4]) image.layers.push_back(layer_of(layer));
  return image;
}

/// The inverse of dict_of().
PolicyFile policy_of(const nb::dict& values) {
  PolicyFile policy;
  policy.scenario = nb::cast<std::string>(values["scenario"]);
  policy.scenario_hash = nb::cast<std::string>(values["scenario_hash"]);
  policy.algorithm = nb::cast<std::string>(values["algorithm"]);
  policy.steps = nb::cast<std::int64_t>(values["steps"]);
  policy.observation_size = nb::cast<int>(values["observation_size"]);
  policy.action_size = nb::cast<int>(values["action_size"]);
  for (nb::handle agent : values["agents"]) {
    policy.agents.push_back(
        {nb::cast<std::vector<int>>(agent[0]), nb::cast<std::vector<int>>(agent[1])});
  }
  const auto squash = nb::cast<std::string>(values["action_squash"]);
  policy.squash = squash == "tanh" ? ActionSquash::kTanh : ActionSquash::kClip;
  policy.mean = numbers_of(values["mean"]);
  policy.scale = numbers_of(values["scale"]);
  policy.clip = nb::cast<double>(values["clip"]);
  for (nb::handle image : values["images"]) policy.images.push_back(image_of(image));
  for (nb::handle layer : values["layers"]) policy.layers.push_back(layer_of(layer));
  return policy;
}

}  // namespace

nb::dict dict_of(const PolicyFile& policy) {
  nb::dict values;
  values["scenario"] = policy.scenario;
  values["scenario_hash"] = policy.scenario_hash;
  values["algorithm"] = policy.algorithm;
  values["steps"] = policy.steps;
  values["observation_size"] = policy.observation_size;
  values["action_size"] = policy.action_size;
  nb::list agents;
  for (const PolicyAgent& agent : policy.agents) {
    agents.append(nb::make_tuple(agent.observation, agent.action));
  }
  values["agents"] = agents;
  values["action_squash"] = policy.squash == ActionSquash::kTanh ? "tanh" : "clip";
  values["mean"] = vector_of(policy.mean);
  values["scale"] = vector_of(policy.scale);
  values["clip"] = policy.clip;
  nb::list images;
  for (const PolicyImage& image : policy.images) {
    nb::list convolutions;
    for (const PolicyLayer& layer : image.layers) convolutions.append(tuple_of(layer));
    images.append(nb::make_tuple(image.column,
                                 nb::make_tuple(image.height, image.width, image.channels),
                                 image.low, image.high, convolutions));
  }
  values["images"] = images;
  nb::list layers;
  for (const PolicyLayer& layer : policy.layers) layers.append(tuple_of(layer));
  values["layers"] = layers;
  return values;
}

nb::tuple tuple_of(const PolicyLayer& layer) {
  const auto rows = static_cast<std::size_t>(layer.weight_rows());
  const auto columns = static_cast<std::size_t>(layer.inputs);
  const nb::object weight = copy_of<double>(layer.weight, {rows, columns});
  if (layer.kind == LayerKind::kDense) {
    return nb::make_tuple(weight, copy_of<double>(layer.bias, {rows}), name(layer.activation));
  }
  if (layer.kind == LayerKind::kConv) {
    const ConvShape& shape = layer.conv;
    return nb::make_tuple(weight, copy_of<double>(layer.bias, {rows}), name(layer.activation),
                          nb::make_tuple(shape.kernel_height, shape.kernel_width, shape.stride,
                                         shape.same ? "same" : "valid"));
  }
  const auto units = static_cast<std::size_t>(layer.outputs);
  return nb::make_tuple(weight, copy_of<double>(layer.bias, {rows}), name(layer.activation),
                        copy_of<double>(layer.state_weight, {rows, units}),
                        copy_of<double>(layer.state_bias, {rows}));
}

void bind_policy(nb::module_& m) {
  m.attr("MOST_LAYERS") = kMostLayers;
  m.def(
      "policy_seal",
      [](const nb::bytes& content) {
        return bytes_of(policy_seal(std::string_view(content.c_str(), content.size())));
      },
      nb::arg("content"),
      "The first 512 bytes of a policy.h5 whose other bytes are `content`. docs/policies.md says "
      "what they hold.");
  m.def(
      "shipped_policy_file",
      [](const std::string& scenario, const std::string& trained) {
        return shipped_policy_file(scenario, trained.empty() ? scenario : trained).string();
      },
      nb::arg("scenario"), nb::arg("trained") = "",
      "The file of the policy that is shipped for a scenario. Raises Error where there is none; it "
      "advises to train `trained`, the scenario's file or, if empty, its name.");
  m.def("read_policy_file", &read_policy_file, nb::arg("path"),
        nb::sig("def read_policy_file(path: str) -> dict[str, typing.Any]"),
        "What a policy.h5 holds, by the rules of `skybody run --policy`: sizes fit together and "
        "every number is finite. `layers` are (weight, bias, activation), "
        "of recurrent ones with state_weight and state_bias behind, of convolutions with "
        "(kernel height, kernel width, stride, padding); `images` (column, (height, width, "
        "channels), low, high, layers); "
        "`agents` (entries of the observation, entries of the action) of each robot, where robots "
        "share the network; `mean` and `scale` are "
        "empty without a normalization. Error, which names the file, for any other file.");
  m.def(
      "policy_file_bytes",
      [](const nb::dict& values, std::uint64_t seed) {
        return bytes_of(policy_bytes(policy_of(values), seed));
      },
      nb::arg("values"), nb::arg("seed"),
      nb::sig("def policy_file_bytes(values: dict[str, typing.Any], seed: int) -> bytes"),
      "The bytes of the policy.h5 of `values`, which are as `read_policy_file` gives them, with "
      "float64 arrays. `seed` is that of the training. Equal values give equal bytes.");
  m.def(
      "printable",
      [](const nb::bytes& text) {
        return printable({text.c_str(), text.size()});
      },
      nb::arg("text"),
      "UTF-8 bytes as one line that is safe to print: control characters and bytes that are no "
      "UTF-8 become \\xNN.");
}

}  // namespace skybody::python
