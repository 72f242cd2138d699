#include "core/policy/image_features.h"

#include <algorithm>
#include <cstring>

#include "core/policy/activations.h"

namespace skybody {
namespace {

/// Rows and columns of a window inside of the image.
struct Range {
  int begin, end;  ///< within the window
  int first;       ///< of the image, at `begin`
};

/// @param window  index of the window, of `windows` in this direction
Range inside(int window, int windows, int size, int kernel, const ConvShape& shape) {
  const int border = shape.same ? std::max(0, (windows - 1) * shape.stride + kernel - size) / 2 : 0;
  const int first = window * shape.stride - border;
  const int begin = std::max(0, -first);
  return {begin, std::min(kernel, size - first), first + begin};
}

}  // namespace

ImageFeatures::ImageFeatures(const PolicyImage& image) : image_(image) {
  std::size_t largest = static_cast<std::size_t>(image.height) *
                        static_cast<std::size_t>(image.width) *
                        static_cast<std::size_t>(image.channels);
  for (const PolicyLayer& layer : image.layers) {
    largest = std::max(largest, static_cast<std::size_t>(layer.conv.output_size()));
    const auto inputs = static_cast<std::size_t>(layer.inputs);
    const auto outputs = static_cast<std::size_t>(layer.outputs);
    std::vector<double>& weight = weights_.emplace_back(layer.weight.size());
    for (std::size_t o = 0; o < outputs; ++o) {
      for (std::size_t i = 0; i < inputs; ++i)
        weight[i * outputs + o] = layer.weight[o * inputs + i];
    }
  }
  values_.resize(largest);
  next_.resize(largest);
}

void ImageFeatures::evaluate(ColumnType type, const std::uint8_t* pixels, double* features) {
  switch (type) {
    case ColumnType::kFloat32:
      scale<float>(pixels);
      break;
    case ColumnType::kUint8:
      scale<std::uint8_t>(pixels);
      break;
    case ColumnType::kUint16:
      scale<std::uint16_t>(pixels);
      break;
  }
  for (std::size_t k = 0; k < image_.layers.size(); ++k) {
    convolve(image_.layers[k], weights_[k]);
    values_.swap(next_);
  }
  std::copy_n(values_.data(), this->features(), features);
}

/// In float, as in training. A pixel that is no number counts as `high`.
template <class T>
void ImageFeatures::scale(const std::uint8_t* pixels) {
  const auto low = static_cast<float>(image_.low), high = static_cast<float>(image_.high);
  const float factor = 1.0f / (high - low);
  const int count = image_.height * image_.width * image_.channels;
  for (int i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, pixels + static_cast<std::size_t>(i) * sizeof(T), sizeof(T));
    const auto pixel = static_cast<float>(value);
    const float below = pixel < high ? pixel : high;
    values_[static_cast<std::size_t>(i)] =
        static_cast<double>(((below > low ? below : low) - low) * factor);
  }
}

/// From values_ to next_.
void ImageFeatures::convolve(const PolicyLayer& layer, const std::vector<double>& weight) {
  const ConvShape& s = layer.conv;
  double* sums = next_.data();
  for (int i = 0; i < s.out_height(); ++i) {
    const Range rows = inside(i, s.out_height(), s.height, s.kernel_height, s);
    for (int j = 0; j < s.out_width(); ++j, sums += s.outputs) {
      const Range columns = inside(j, s.out_width(), s.width, s.kernel_width, s);
      std::copy(layer.bias.begin(), layer.bias.end(), sums);
      for (int r = rows.begin; r < rows.end; ++r) {
        const double* x =
            values_.data() + static_cast<std::ptrdiff_t>(s.channels) *
                                 ((rows.first + r - rows.begin) * s.width + columns.first);
        const double* w = weight.data() + static_cast<std::ptrdiff_t>(s.outputs) * s.channels *
                                              (r * s.kernel_width + columns.begin);
        const int count = (columns.end - columns.begin) * s.channels;
        for (int k = 0; k < count; ++k, w += s.outputs) {
          for (int o = 0; o < s.outputs; ++o) sums[o] += w[o] * x[k];
        }
      }
      for (int o = 0; o < s.outputs; ++o) sums[o] = activate(sums[o], layer.activation);
    }
  }
}

}  // namespace skybody
