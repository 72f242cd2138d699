// The network of a policy file by itself, and its parts for `skybody export --to c`.
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <span>
#include <string>
#include <vector>

#include "core/base/system/error.h"
#include "core/policy/layer_weights.h"
#include "core/policy/network_policy.h"
#include "python/native/arrays.h"
#include "python/native/bindings.h"
#include "python/native/network_layers_text.h"

namespace skybody::python {
namespace {

using Floats = nb::ndarray<const float, nb::c_contig, nb::device::cpu>;
using Bytes = nb::ndarray<const std::uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Matrix = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

std::size_t pixel_bytes(const std::string& type) {
  return type == "float32" ? 4 : type == "uint16" ? 2 : 1;
}

ColumnType type_of(const std::string& type) {
  return type == "float32"  ? ColumnType::kFloat32
         : type == "uint16" ? ColumnType::kUint16
                            : ColumnType::kUint8;
}

/// A network with the images' types; evaluates rows one after another.
class PolicyNetwork {
 public:
  PolicyNetwork(const std::string& file, std::vector<std::string> types)
      : policy_(std::filesystem::path(file)), types_(std::move(types)) {
    if (types_.size() != policy_.policy().images.size()) {
      throw nb::value_error("as many types are needed as the policy sees images");
    }
  }

  nb::object act(const Floats& observation, const std::vector<Bytes>& images) {
    const std::size_t rows = observation.shape(0);
    check(observation, images);
    const auto width = static_cast<std::size_t>(policy_.policy().action_size);
    std::vector<float> actions(rows * width);
    std::vector<ImageView> views(images.size());
    for (std::size_t r = 0; r < rows; ++r) {
      for (std::size_t k = 0; k < images.size(); ++k) {
        views[k] = {type_of(types_[k]), images[k].data() + r * images[k].shape(1)};
      }
      policy_.act(std::span(observation.data() + r * observation.shape(1), observation.shape(1)),
                  std::span(actions).subspan(r * width, width), views);
    }
    return copy_of<float>(actions, {rows, width});
  }

  void reset() { policy_.reset(); }

 private:
  void check(const Floats& observation, const std::vector<Bytes>& images) const {
    const PolicyFile& policy = policy_.policy();
    const auto width = static_cast<std::size_t>(policy.observation_size);
    if (observation.ndim() != 2 || observation.shape(1) != width) {
      throw nb::value_error(
          ("observations must have the shape (n, " + std::to_string(width) + ")").c_str());
    }
    if (images.size() != types_.size()) throw nb::value_error("an image is missing");
    for (std::size_t k = 0; k < images.size(); ++k) {
      const PolicyImage& image = policy.images[k];
      const std::size_t bytes = pixel_bytes(types_[k]) * static_cast<std::size_t>(image.height) *
                                static_cast<std::size_t>(image.width) *
                                static_cast<std::size_t>(image.channels);
      if (images[k].shape(0) != observation.shape(0) || images[k].shape(1) != bytes) {
        throw nb::value_error("an image has the wrong shape; needed: (n, bytes)");
      }
    }
  }

  NetworkPolicy policy_;
  std::vector<std::string> types_;
};

nb::object panels_of(const Matrix& weight) {
  const auto outputs = weight.shape(0), inputs = weight.shape(1);
  const std::vector<double> rows(weight.data(), weight.data() + outputs * inputs);
  const std::vector<float> panels =
      pack_panels(rows, static_cast<int>(outputs), static_cast<int>(inputs));
  return copy_of<float>(panels, {panels.size()});
}

}  // namespace

void bind_policy_network(nb::module_& m) {
  nb::class_<PolicyNetwork>(m, "PolicyNetwork",
                            "The network of a policy.h5, evaluated as by `skybody run --policy`.")
      .def(nb::init<const std::string&, std::vector<std::string>>(), nb::arg("file"),
           nb::arg("types") = std::vector<std::string>{},
           "file: policy.h5, or the folder of a training run\n"
           "types: of each image's pixels: `float32`, `uint8` or `uint16`\n\n"
           "Raises Error if it cannot be read.")
      .def("act", &PolicyNetwork::act, nb::arg("observation"),
           nb::arg("images") = std::vector<Bytes>{},
           nb::sig("def act(self, observation: numpy.typing.NDArray[numpy.float32], images: "
                   "Sequence[numpy.typing.NDArray[numpy.uint8]] = ()) -> "
                   "numpy.typing.NDArray[numpy.float32]"),
           "Actions (n, A) in [-1, 1] of observations (n, O), row after row; images are (n, bytes) "
           "each. The recurrent state goes on from row to row, and to the next call.\n\n"
           "Raises ValueError for other shapes.")
      .def("reset", &PolicyNetwork::reset, "Empties the recurrent state: an episode begins.");
  m.def("policy_panels", &panels_of, nb::arg("weight"),
        nb::sig("def policy_panels(weight: numpy.typing.NDArray[numpy.float64]) -> "
                "numpy.typing.NDArray[numpy.float32]"),
        "A layer's weight (out, in) in the order of core/policy/network_layers.h.");
  m.def(
      "network_layers_source", [] { return std::string(kNetworkLayersText); },
      "The text of core/policy/network_layers.h: C99, the layers of a policy.");
}

}  // namespace skybody::python
