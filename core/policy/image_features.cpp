#include "core/policy/image_features.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "core/policy/network_layers.h"

namespace skybody {
namespace {

/// Zeros before the first row (or column) of an image.
int border(int windows, int size, int kernel, const ConvShape& shape) {
  return shape.same ? std::max(0, (windows - 1) * shape.stride + kernel - size) / 2 : 0;
}

LayerConvolution convolution_of(const ConvShape& s) {
  return {.height = s.height,
          .width = s.width,
          .channels = s.channels,
          .kernel_height = s.kernel_height,
          .kernel_width = s.kernel_width,
          .stride = s.stride,
          .top = border(s.out_height(), s.height, s.kernel_height, s),
          .left = border(s.out_width(), s.width, s.kernel_width, s),
          .out_height = s.out_height(),
          .out_width = s.out_width(),
          .outputs = s.outputs};
}

}  // namespace

ImageFeatures::ImageFeatures(const PolicyImage& image) : image_(image) {
  std::size_t largest = static_cast<std::size_t>(image.height) *
                        static_cast<std::size_t>(image.width) *
                        static_cast<std::size_t>(image.channels);
  for (const PolicyLayer& layer : image.layers) {
    largest = std::max(largest, static_cast<std::size_t>(layer.conv.output_size()));
    weights_.emplace_back(layer);
  }
  values_.resize(largest);
  next_.resize(largest);
}

void ImageFeatures::evaluate(ColumnType type, const std::uint8_t* pixels, float* features) {
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
    const PolicyLayer& layer = image_.layers[k];
    const LayerConvolution convolution = convolution_of(layer.conv);
    layer_convolve(&convolution, weights_[k].weight.data(), weights_[k].bias.data(),
                   static_cast<int>(layer.activation), values_.data(), next_.data());
    values_.swap(next_);
  }
  std::copy_n(values_.data(), this->features(), features);
}

template <class T>
void ImageFeatures::scale(const std::uint8_t* pixels) {
  const auto low = static_cast<float>(image_.low), high = static_cast<float>(image_.high);
  const int count = image_.height * image_.width * image_.channels;
  for (int i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, pixels + static_cast<std::size_t>(i) * sizeof(T), sizeof(T));
    values_[static_cast<std::size_t>(i)] = layer_pixel(static_cast<float>(value), low, high);
  }
}

}  // namespace skybody
