#include "core/io/files/policy_file.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <system_error>

#include "core/base/system/error.h"
#include "core/io/files/hdf5_reader.h"
#include "core/io/files/policy_checksum.h"
#include "core/io/files/text.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMostValues = 1 << 24;  // of an observation, an action or a layer
constexpr std::int64_t kMostExtent = 1 << 15;  // of an image, a kernel or a stride

class PolicyReader {
 public:
  explicit PolicyReader(const fs::path& file)
      : file_(file, "policy", kPolicyRemedy, read_sealed_policy(file)) {}

  PolicyFile read() {
    read_header();
    if (file_.has("/agents")) read_agents();
    if (file_.has("/normalization")) read_normalization();
    while (file_.has(image_group())) read_image(image_group());
    while (file_.has(layer_group())) read_layer();
    check_layers();
    if (const std::string fault = fault_of(policy_); !fault.empty()) file_.fail(fault);
    return std::move(policy_);
  }

 private:
  void read_header() {
    file_.check_format(kPolicyFormat, "export the policy anew");
    policy_.scenario = file_.text("/", "scenario");
    policy_.scenario_hash = file_.text("/", "scenario_hash");
    policy_.algorithm = file_.text("/", "algorithm");
    policy_.steps = file_.integer("/", "steps");
    policy_.observation_size = read_size("/", "observation_size");
    policy_.action_size = read_size("/", "action_size");
    const std::string squash = file_.text("/", "action_squash");
    if (squash != "clip" && squash != "tanh") {
      file_.fail("`action_squash` is `" + squash + "`; allowed: clip, tanh");
    }
    policy_.squash = squash == "tanh" ? ActionSquash::kTanh : ActionSquash::kClip;
  }

  int read_size(const std::string& object, const char* name, std::int64_t most = kMostValues) {
    const std::int64_t size = file_.integer(object, name);
    if (size < 1 || size > most) {
      file_.fail("`" + std::string(name) + "`" + (object == "/" ? "" : " of `" + object + "`") +
                 " is " + std::to_string(size) + "; allowed: 1.." + std::to_string(most));
    }
    return static_cast<int>(size);
  }

  void read_agents() {
    const std::vector<std::vector<int>> seen =
        read_entries("/agents/observation", policy_.observation_size);
    const std::vector<std::vector<int>> decided =
        read_entries("/agents/action", policy_.action_size);
    if (seen.size() != decided.size()) {
      file_.fail("`/agents` has observations of " + std::to_string(seen.size()) +
                 " robots and actions of " + std::to_string(decided.size()));
    }
    std::vector<int> owners(static_cast<std::size_t>(policy_.action_size));
    for (std::size_t k = 0; k < seen.size(); ++k) {
      policy_.agents.push_back({seen[k], decided[k]});
      for (const int entry : decided[k]) ++owners[static_cast<std::size_t>(entry)];
    }
    const auto bad = std::find_if(owners.begin(), owners.end(), [](int n) { return n != 1; });
    if (bad == owners.end()) return;
    file_.fail("value " + std::to_string(bad - owners.begin()) + " of the action is decided by " +
               std::to_string(*bad) + " robots of `/agents/action`; needed: one");
  }

  /// Rows of indices below `size`, one row per robot.
  std::vector<std::vector<int>> read_entries(const std::string& name, int size) {
    const Hdf5Reader::Shape shape = file_.shape(name);
    if (shape.rank != 2 || shape.rows < 1 || shape.columns < 1) {
      file_.fail("`" + name + "` has " + text_of(shape) + " values; needed: robots x entries");
    }
    const std::vector<std::int32_t> all = file_.all<std::int32_t>(name);
    std::vector<std::vector<int>> rows;
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (all[k] < 0 || all[k] >= size) {
        file_.fail("value " + std::to_string(k) + " of `" + name + "` is " +
                   std::to_string(all[k]) + "; allowed: 0.." + std::to_string(size - 1));
      }
      if (k % shape.columns == 0) rows.emplace_back();
      rows.back().push_back(all[k]);
    }
    return rows;
  }

  std::vector<double> read_vector(const std::string& name, int size) {
    const Hdf5Reader::Shape shape = file_.shape(name);
    if (shape.rank != 1 || shape.rows != static_cast<std::size_t>(size)) {
      file_.fail("`" + name + "` has " + text_of(shape) +
                 " values; needed: " + std::to_string(size));
    }
    return finite(name, file_.all<double>(name));
  }

  std::vector<double> finite(const std::string& name, std::vector<double> values) {
    const auto bad =
        std::find_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); });
    if (bad != values.end()) {
      file_.fail("value " + std::to_string(bad - values.begin()) + " of `" + name +
                 "` is not finite: the network cannot fly; take an earlier checkpoint");
    }
    return values;
  }

  static std::string text_of(const Hdf5Reader::Shape& shape) {
    return shape.rank == 1 ? std::to_string(shape.rows)
                           : std::to_string(shape.rows) + " x " + std::to_string(shape.columns);
  }

  void read_normalization() {
    policy_.mean = read_vector("/normalization/mean", policy_.input_size());
    policy_.scale = read_vector("/normalization/scale", policy_.input_size());
    policy_.clip = file_.real("/normalization", "clip");
  }

  std::string image_group() const { return "/images/" + std::to_string(policy_.images.size()); }

  void read_image(const std::string& group) {
    if (!policy_.agents.empty()) file_.fail("`/agents` and `/images` exclude one another");
    if (policy_.images.size() == kMostLayers) {
      file_.fail("more than " + std::to_string(kMostLayers) + " images");
    }
    PolicyImage image;
    image.column = file_.text(group, "column");
    image.height = read_size(group, "height", kMostExtent);
    image.width = read_size(group, "width", kMostExtent);
    image.channels = read_size(group, "channels", kMostExtent);
    image.low = file_.real(group, "low");
    image.high = file_.real(group, "high");
    if (!(std::isfinite(image.low) && std::isfinite(image.high) && image.low < image.high)) {
      file_.fail("`" + group + "` has the range " + format_number(image.low) + " to " +
                 format_number(image.high) + "; needed: finite, and `low` below `high`");
    }
    ConvShape shape = {.height = image.height, .width = image.width, .channels = image.channels};
    for (std::string layer; file_.has(layer = group + "/" + std::to_string(image.layers.size()));) {
      if (image.layers.size() == kMostLayers) {
        file_.fail("more than " + std::to_string(kMostLayers) + " layers in `" + group + "`");
      }
      const ConvShape& read = image.layers.emplace_back(read_conv(layer, shape)).conv;
      shape = {.height = read.out_height(), .width = read.out_width(), .channels = read.outputs};
    }
    if (image.layers.empty()) file_.fail("`" + group + "/0` is missing in this policy file");
    if (shape.height != 1 || shape.width != 1) {
      file_.fail("the last layer of `" + group + "` has " + std::to_string(shape.height) + " x " +
                 std::to_string(shape.width) + " windows; needed: one");
    }
    policy_.images.push_back(std::move(image));
  }

  /// @param shape  with the sizes of the input
  PolicyLayer read_conv(const std::string& group, ConvShape shape) {
    shape.kernel_height = read_size(group, "kernel_height", kMostExtent);
    shape.kernel_width = read_size(group, "kernel_width", kMostExtent);
    shape.stride = read_size(group, "stride", kMostExtent);
    shape.outputs = read_size(group, "outputs");
    const std::string padding = file_.text(group, "padding");
    if (padding != "valid" && padding != "same") {
      file_.fail("`padding` of `" + group + "` is `" + padding + "`; allowed: valid, same");
    }
    shape.same = padding == "same";
    if (!shape.same && (shape.kernel_height > shape.height || shape.kernel_width > shape.width)) {
      file_.fail("the kernel of `" + group + "` is larger than its image of " +
                 std::to_string(shape.height) + " x " + std::to_string(shape.width));
    }
    const std::int64_t window =
        std::int64_t{shape.kernel_height} * shape.kernel_width * shape.channels;
    const std::int64_t output = std::int64_t{shape.out_height()} * shape.out_width();
    if (std::int64_t{shape.height} * shape.width * shape.channels > kMostValues ||
        window > kMostValues || output * shape.outputs > kMostValues) {
      file_.fail("an image of `" + group + "` has more than " + std::to_string(kMostValues) +
                 " values");
    }
    const std::string name = group + "/weight";
    const Hdf5Reader::Shape weight = file_.shape(name);
    if (weight.rank != 2 || weight.rows != static_cast<std::size_t>(shape.outputs) ||
        weight.columns != static_cast<std::size_t>(window)) {
      file_.fail("`" + name + "` has " + text_of(weight) + " values; needed: " +
                 std::to_string(shape.outputs) + " x " + std::to_string(window));
    }
    PolicyLayer layer;
    layer.kind = LayerKind::kConv;
    layer.conv = shape;
    layer.inputs = static_cast<int>(window);
    layer.outputs = shape.outputs;
    layer.weight = finite(name, file_.all<double>(name));
    layer.bias = read_vector(group + "/bias", layer.outputs);
    layer.activation = read_activation(group);
    return layer;
  }

  std::string layer_group() const { return "/layers/" + std::to_string(policy_.layers.size()); }

  int first_inputs() const { return policy_.input_size() + policy_.feature_size(); }

  void read_layer() {
    const std::string group = layer_group(), name = group + "/weight";
    if (policy_.layers.size() == kMostLayers) {
      file_.fail("more than " + std::to_string(kMostLayers) + " layers");
    }
    const Hdf5Reader::Shape shape = file_.shape(name);
    const int inputs = policy_.layers.empty() ? first_inputs() : policy_.layers.back().outputs;
    PolicyLayer layer;
    layer.kind = kind_of(group);
    const auto gates = static_cast<std::size_t>(layer.gates());
    if (shape.rank != 2 || shape.rows < 1 || shape.rows > kMostValues ||
        shape.columns != static_cast<std::size_t>(inputs) || shape.rows % gates != 0) {
      file_.fail("`" + name + "` has " + text_of(shape) + " values; needed: " +
                 (gates > 1 ? "3 or 4 units x " : "outputs x ") + std::to_string(inputs));
    }
    layer.inputs = inputs;
    layer.outputs = static_cast<int>(shape.rows / gates);
    layer.weight = finite(name, file_.all<double>(name));
    layer.bias = read_vector(group + "/bias", layer.weight_rows());
    if (layer.is_recurrent()) {
      read_state_weights(group, layer);
    } else {
      layer.activation = read_activation(group);
    }
    policy_.layers.push_back(std::move(layer));
  }

  /// By the rows of the weights of the state: 3 or 4 for each of its values.
  LayerKind kind_of(const std::string& group) const {
    const std::string name = group + "/state_weight";
    if (!file_.has(name)) return LayerKind::kDense;
    const Hdf5Reader::Shape shape = file_.shape(name);
    const bool is_lstm = shape.rank == 2 && shape.columns > 0 && shape.rows == 4 * shape.columns;
    return is_lstm ? LayerKind::kLstm : LayerKind::kGru;
  }

  void read_state_weights(const std::string& group, PolicyLayer& layer) {
    const std::string name = group + "/state_weight";
    const Hdf5Reader::Shape shape = file_.shape(name);
    if (shape.rank != 2 || shape.rows != static_cast<std::size_t>(layer.weight_rows()) ||
        shape.columns != static_cast<std::size_t>(layer.outputs)) {
      file_.fail("`" + name + "` has " + text_of(shape) + " values; needed: " +
                 std::to_string(layer.weight_rows()) + " x " + std::to_string(layer.outputs));
    }
    layer.state_weight = finite(name, file_.all<double>(name));
    layer.state_bias = read_vector(group + "/state_bias", layer.weight_rows());
  }

  Activation read_activation(const std::string& group) {
    const std::string name = file_.text(group, "activation");
    if (const std::optional<Activation> found = find_activation(name)) return *found;
    std::string allowed;
    for (const char* one : kActivationNames)
      allowed += (allowed.empty() ? "" : ", ") + std::string(one);
    file_.fail("`activation` of `" + group + "` is `" + name + "`; allowed: " + allowed);
  }

  void check_layers() {
    if (policy_.layers.empty()) file_.fail("`/layers/0` is missing in this policy file");
    const int outputs = policy_.layers.back().outputs, needed = policy_.output_size();
    if (outputs == needed) return;
    const char* what = policy_.agents.empty() ? "`action_size` is " : "`/agents/action` has ";
    file_.fail("the last layer gives " + std::to_string(outputs) + " values; " + what +
               std::to_string(needed));
  }

  Hdf5Reader file_;
  PolicyFile policy_;
};

/// The step of a folder called step_NNNNNNNNNNNN, else -1.
std::int64_t checkpoint_step(const fs::path& folder) {
  constexpr std::size_t kPrefix = 5, kDigits = 12;
  const std::string name = folder.filename().string();
  if (name.rfind("step_", 0) != 0 || name.size() != kPrefix + kDigits) return -1;
  if (name.find_first_not_of("0123456789", kPrefix) != std::string::npos) return -1;
  return std::stoll(name.substr(kPrefix));
}

/// The checkpoint with the highest step that has a policy, or an empty path.
fs::path newest_checkpoint(const fs::path& folder) {
  fs::path newest;
  std::int64_t step = -1;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (checkpoint_step(entry.path()) <= step || !fs::exists(entry.path() / "policy.h5", error)) {
      continue;
    }
    newest = entry.path() / "policy.h5";
    step = checkpoint_step(entry.path());
  }
  return newest;
}

}  // namespace

std::string fault_of(const PolicyFile& policy) {
  const std::string& hash = policy.scenario_hash;
  const bool is_hash = hash.size() == 16 && hash.find_first_not_of("0123456789abcdef") == hash.npos;
  if (!hash.empty() && !is_hash) {
    return "`scenario_hash` is `" + hash + "`; needed: 16 hexadecimal digits";
  }
  if (policy.steps < 0) return "`steps` is " + std::to_string(policy.steps) + "; allowed: >= 0";
  if (policy.scale.empty()) return "";
  const auto bad =
      std::find_if(policy.scale.begin(), policy.scale.end(), [](double s) { return !(s > 0.0); });
  if (bad != policy.scale.end()) {
    return "value " + std::to_string(bad - policy.scale.begin()) +
           " of `/normalization/scale` is " + format_number(*bad) + "; allowed: > 0";
  }
  if (policy.clip > 0.0) return "";
  return "`clip` of `/normalization` is " + format_number(policy.clip) + "; allowed: > 0";
}

PolicyFile read_policy(const fs::path& file) { return PolicyReader(file).read(); }

fs::path find_policy(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return path;
  if (fs::exists(path / "policy.h5", ignored)) return path / "policy.h5";
  fs::path newest = newest_checkpoint(path / "checkpoints");
  if (newest.empty()) newest = newest_checkpoint(path);
  if (!newest.empty()) return newest;
  throw Error("the folder " + path.string() +
              " has neither policy.h5 nor checkpoints/step_NNNNNNNNNNNN/policy.h5; give a "
              "checkpoint, a training run's folder or a policy file");
}

}  // namespace skybody
