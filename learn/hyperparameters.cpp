#include "learn/hyperparameters.h"

#include <cstdio>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/base/system/error.h"

namespace skybody::learn {
namespace {

constexpr std::string_view P = "P", G = "G", B = "B";

constexpr HyperparameterRow kRows[] = {
#define SKYBODY_ROW(TYPE, NAME, DEFAULT, LEAST, LARGEST, ALGORITHMS, MEANING) \
  {#NAME, LEAST, LARGEST, ALGORITHMS != G, ALGORITHMS != P, MEANING},
    SKYBODY_HYPERPARAMETERS(SKYBODY_ROW)
#undef SKYBODY_ROW
};

template <class T>
void check_value(const HyperparameterRow& row, const T& value) {
  if constexpr (std::is_arithmetic_v<T>) {
    const auto number = static_cast<double>(value);
    if (number >= row.least && number <= row.largest) return;
    char text[160];
    std::snprintf(text, sizeof(text), "hyper-parameter %s = %g: allowed is %g to %g", row.name,
                  number, row.least, row.largest);
    throw Error(text);
  }
}

void check_value(const HyperparameterRow& row, const Sizes& sizes) {
  for (const int size : sizes) check_value(row, size);
}

/// A trained policy must be readable: besides the hidden layers its file has the output layer, and
/// the recurrent layer if there is a memory.
void check_layers(const Hyperparameters& hyper, Algorithm algorithm) {
  const bool has_memory = algorithm == Algorithm::kFastPpo && hyper.recurrent_units > 0;
  const std::size_t most = kMostLayers - (has_memory ? 2 : 1);
  if (hyper.hidden.size() <= most) return;
  throw Error("hyper-parameter hidden = " + std::to_string(hyper.hidden.size()) +
              " sizes: allowed is at most " + std::to_string(most) + ", as a policy file has " +
              std::to_string(kMostLayers) + " layers with the last one" +
              (has_memory ? " and the recurrent one" : ""));
}

/// One kernel and one stride for each convolution.
void check_convolutions(const Hyperparameters& hyper) {
  const std::size_t layers = hyper.cnn_channels.size();
  if (hyper.cnn_kernels.size() == layers && hyper.cnn_strides.size() == layers &&
      layers < kMostLayers) {
    return;
  }
  throw Error("hyper-parameters cnn_channels, cnn_kernels and cnn_strides have " +
              std::to_string(layers) + ", " + std::to_string(hyper.cnn_kernels.size()) + " and " +
              std::to_string(hyper.cnn_strides.size()) +
              " entries: give one of each per convolution, for at most " +
              std::to_string(kMostLayers - 1));
}

}  // namespace

std::span<const HyperparameterRow> hyperparameter_rows() { return kRows; }

std::vector<std::string> hyperparameter_names(Algorithm algorithm) {
  std::vector<std::string> names;
  for (const HyperparameterRow& row : kRows) {
    if (has(row, algorithm)) names.emplace_back(row.name);
  }
  return names;
}

void check(const Hyperparameters& hyper, Algorithm algorithm) {
  const HyperparameterRow* row = kRows;
#define SKYBODY_ROW(TYPE, NAME, DEFAULT, LEAST, LARGEST, ALGORITHMS, MEANING) \
  if (has(*row, algorithm)) check_value(*row, hyper.NAME);                    \
  ++row;
  SKYBODY_HYPERPARAMETERS(SKYBODY_ROW)
#undef SKYBODY_ROW
  check_layers(hyper, algorithm);
  check_convolutions(hyper);
}

}  // namespace skybody::learn
