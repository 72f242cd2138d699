#include "learn/network/image_encoder.h"

#include <algorithm>
#include <string>

#include "core/base/system/error.h"
#include "core/env/column_type.h"
#include "learn/network/growing_array.h"
#include "learn/network/kernels/kernels.h"
#include "learn/network/product.h"

namespace skybody::learn {
namespace {

constexpr double kGain = 1.4142135623730951;
constexpr int kChunkValues = 1 << 16, kMostChunk = 32;  // as in conv2d.cpp

static_assert(static_cast<int>(PixelType::kFloat32) == static_cast<int>(ColumnType::kFloat32) &&
              static_cast<int>(PixelType::kUint8) == static_cast<int>(ColumnType::kUint8) &&
              static_cast<int>(PixelType::kUint16) == static_cast<int>(ColumnType::kUint16));

void check_lists(const EncoderShape& shape) {
  if (shape.kernels.size() == shape.channels.size() &&
      shape.strides.size() == shape.channels.size()) {
    return;
  }
  throw Error("an image encoder has " + std::to_string(shape.channels.size()) + " channels, " +
              std::to_string(shape.kernels.size()) + " kernels and " +
              std::to_string(shape.strides.size()) + " strides; needed: one of each per layer");
}

}  // namespace

int ImageFormat::bytes() const { return pixels() * info_of(static_cast<ColumnType>(type)).bytes; }

ImageEncoder::ImageEncoder(const ImageFormat& format, const EncoderShape& shape, Isa isa)
    : format_(format), kernels_(&kernels_of(isa)) {
  check_lists(shape);
  ConvShape layer = {.height = format.height, .width = format.width, .channels = format.channels};
  int pixel = format.channels;
  std::size_t begin = 0;
  const auto add = [&] {
    const Conv2d& conv = layers_.emplace_back(layer, pixel, shape.activation, isa);
    begins_.push_back(begin);
    begin += conv.parameter_count();
    layer.height = conv.shape().out_height();
    layer.width = conv.shape().out_width();
    layer.channels = conv.shape().outputs;
    pixel = conv.output_pixel();
  };
  for (std::size_t k = 0; k < shape.channels.size(); ++k) {
    layer.outputs = shape.channels[k];
    layer.kernel_height = layer.kernel_width = shape.kernels[k];
    layer.stride = shape.strides[k];
    layer.same = shape.same;
    add();
  }
  layer.outputs = shape.features;
  layer.kernel_height = layer.height;
  layer.kernel_width = layer.width;
  layer.stride = 1;
  layer.same = false;
  add();
  int largest = format.pixels();
  for (const Conv2d& conv : layers_) largest = std::max(largest, conv.output_size());
  chunk_ = std::clamp(kChunkValues / largest, 1, kMostChunk);
}

std::size_t ImageEncoder::parameter_count() const {
  return begins_.back() + layers_.back().parameter_count();
}

void ImageEncoder::initialize(std::span<float> parameters, std::uint64_t key,
                              std::uint64_t stream) const {
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    layers_[k].initialize(parameters.subspan(begins_[k]), kGain, {key, stream, k});
  }
}

void ImageEncoder::transpose(std::span<const float> parameters,
                             TransposedEncoder& transposed) const {
  transposed.layers.resize(layers_.size());
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    layers_[k].transpose(parameters.subspan(begins_[k]), transposed.layers[k]);
  }
}

/// Converts pixels to the first layer's inputs.
void ImageEncoder::scale(const std::uint8_t* pixels, const int* order, int first, int rows,
                         EncoderActivations& memory) const {
  for (int r = first; r < first + rows; ++r) {
    const int index = order != nullptr ? order[r] : r;
    kernels_->pixels({.from = pixels + product(index, format_.bytes()),
                      .type = format_.type,
                      .count = static_cast<std::size_t>(format_.pixels()),
                      .low = format_.low,
                      .high = format_.high,
                      .scale = 1.0f / (format_.high - format_.low),
                      .to = memory.image.data() + product(r, format_.pixels())});
  }
}

const float* ImageEncoder::input_of(std::size_t layer, int first,
                                    const EncoderActivations& memory) const {
  const AlignedArray<float>& input = layer == 0 ? memory.image : memory.outputs[layer - 1];
  return input.data() + product(first, layers_[layer].input_size());
}

void ImageEncoder::forward(std::span<const float> parameters, const std::uint8_t* pixels,
                           const int* order, int rows, EncoderActivations& memory, float* y,
                           int y_stride) const {
  memory.rows = rows;
  make_large_enough(memory.image, product(rows, format_.pixels()));
  memory.outputs.resize(layers_.size());
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    make_large_enough(memory.outputs[k], product(rows, layers_[k].output_size()));
  }
  for (int first = 0; first < rows; first += chunk_) {
    const int count = std::min(chunk_, rows - first);
    scale(pixels, order, first, count, memory);
    for (std::size_t k = 0; k < layers_.size(); ++k) {
      layers_[k].forward(parameters.subspan(begins_[k]), input_of(k, first, memory), count,
                         memory.scratch,
                         memory.outputs[k].data() + product(first, layers_[k].output_size()));
    }
  }
  const int stride = layers_.back().output_size();
  for (int r = 0; r < rows; ++r) {
    std::copy_n(memory.outputs.back().data() + product(r, stride), features(),
                y + product(r, y_stride));
  }
}

void ImageEncoder::backward(const TransposedEncoder& transposed, EncoderActivations& memory,
                            const float* dy, int dy_stride, std::span<float> gradient) const {
  memory.gradients.resize(layers_.size());
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    make_large_enough(memory.gradients[k], product(chunk_, layers_[k].output_size()));
  }
  const int stride = layers_.back().output_size();
  for (int first = 0; first < memory.rows; first += chunk_) {
    const int count = std::min(chunk_, memory.rows - first);
    float* last = memory.gradients.back().data();
    std::fill_n(last, product(count, stride), 0.0f);
    for (int r = 0; r < count; ++r) {
      std::copy_n(dy + product(first + r, dy_stride), features(), last + product(r, stride));
    }
    for (std::size_t k = layers_.size(); k-- > 0;) {
      layers_[k].backward(transposed.layers[k], input_of(k, first, memory),
                          memory.outputs[k].data() + product(first, layers_[k].output_size()),
                          count, memory.scratch, memory.gradients[k].data(),
                          gradient.subspan(begins_[k]),
                          k == 0 ? nullptr : memory.gradients[k - 1].data());
    }
  }
}

std::vector<PolicyLayer> ImageEncoder::layers(std::span<const float> parameters) const {
  std::vector<PolicyLayer> result;
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    result.push_back(layers_[k].layer(parameters.subspan(begins_[k])));
  }
  return result;
}

void ImageEncoder::set_layers(std::span<const PolicyLayer> layers,
                              std::span<float> parameters) const {
  if (layers.size() != layers_.size()) {
    throw Error("a policy has " + std::to_string(layers.size()) +
                " layers for an image, and this network " + std::to_string(layers_.size()));
  }
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    layers_[k].set_layer(layers[k], parameters.subspan(begins_[k]));
  }
}

}  // namespace skybody::learn
