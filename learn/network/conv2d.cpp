#include "learn/network/conv2d.h"

#include <algorithm>
#include <string>

#include "core/base/system/error.h"
#include "learn/network/epilogues.h"
#include "learn/network/growing_array.h"
#include "learn/network/kernels/kernels.h"
#include "learn/network/product.h"

namespace skybody::learn {
namespace {

constexpr int kMostSize = 1 << 20, kMostValues = 1 << 24;
// Images per call of a kernel: few enough to stay in half of a small L2 cache.
constexpr int kChunkValues = 1 << 16, kMostChunk = 32;
constexpr int kWindowBlock = 96;  // windows whose gradients are in memory at once

void check_sizes(const ConvShape& shape, int input_pixel) {
  for (const int size : {shape.height, shape.width, shape.channels, shape.outputs,
                         shape.kernel_height, shape.kernel_width, shape.stride}) {
    if (size >= 1 && size <= kMostSize) continue;
    throw Error("a convolution has a size of " + std::to_string(size) + "; allowed: 1.." +
                std::to_string(kMostSize));
  }
  if (!shape.same && (shape.kernel_height > shape.height || shape.kernel_width > shape.width)) {
    throw Error("a convolution's kernel of " + std::to_string(shape.kernel_height) + " x " +
                std::to_string(shape.kernel_width) + " is larger than its image of " +
                std::to_string(shape.height) + " x " + std::to_string(shape.width));
  }
  const double image = static_cast<double>(shape.height) * shape.width * input_pixel;
  const double output =
      static_cast<double>(shape.out_height()) * shape.out_width() * padded(shape.outputs);
  const double weight = static_cast<double>(shape.kernel_height) * shape.kernel_width *
                        input_pixel * padded(shape.outputs);
  for (const double values : {image, output, weight}) {
    if (values <= kMostValues) continue;
    throw Error("a convolution's image or weight has " + std::to_string(values) +
                " values; allowed: " + std::to_string(kMostValues));
  }
}

/// Extent of the input that all windows together cover.
int covered(int windows, int stride, int kernel) { return (windows - 1) * stride + kernel; }

}  // namespace

Conv2d::Conv2d(const ConvShape& shape, int input_pixel, Activation activation, Isa isa)
    : shape_((check_sizes(shape, input_pixel), shape)),
      input_pixel_(input_pixel),
      activation_(activation),
      kernels_(&kernels_of(isa)),
      weight_{shape.kernel_height * shape.kernel_width * input_pixel, shape.outputs},
      bordered_height_(
          std::max(shape.height, covered(shape.out_height(), shape.stride, shape.kernel_height))),
      bordered_width_(
          std::max(shape.width, covered(shape.out_width(), shape.stride, shape.kernel_width))),
      chunk_(std::clamp(kChunkValues / std::max(bordered_size(), output_size()), 1, kMostChunk)) {
  offsets_.reserve(product(chunk_, windows()));
  for (int image = 0; image < chunk_; ++image) {
    for (int i = 0; i < shape.out_height(); ++i) {
      for (int j = 0; j < shape.out_width(); ++j) {
        const int pixel = (i * bordered_width_ + j) * shape.stride;
        offsets_.push_back(image * bordered_size() + pixel * input_pixel);
      }
    }
  }
}

std::size_t Conv2d::parameter_count() const {
  return weight_.size() + static_cast<std::size_t>(weight_.padded_columns());
}

/// Index of the weight of an output and of the entry of a window, counted over its channels.
std::size_t Conv2d::weight_index(int output, int entry) const {
  return weight_.at(entry / shape_.channels * input_pixel_ + entry % shape_.channels, output);
}

void Conv2d::initialize(std::span<float> parameters, double gain,
                        const WeightSource& source) const {
  std::fill_n(parameters.begin(), parameter_count(), 0.0f);
  const int entries = shape_.window_size();
  const std::vector<double> values = orthogonal_matrix(entries, shape_.outputs, source);
  for (int entry = 0; entry < entries; ++entry) {
    for (int o = 0; o < shape_.outputs; ++o) {
      const double value = values[product(entry, shape_.outputs) + static_cast<std::size_t>(o)];
      parameters[weight_index(o, entry)] = static_cast<float>(gain * value);
    }
  }
}

void Conv2d::transpose(std::span<const float> parameters, AlignedArray<float>& transposed) const {
  make_large_enough(transposed, weight_.transposed().size());
  learn::transpose(weight_, parameters.data(), transposed.data());
}

// --- borders ------------------------------------------------------------------------------------

bool Conv2d::has_border() const {
  return bordered_height_ > shape_.height || bordered_width_ > shape_.width;
}

/// Copies images into the middle of larger ones, whose borders are and stay zero.
void Conv2d::add_border(const float* x, int count, float* bordered) const {
  const std::size_t line = product(shape_.width, input_pixel_);
  const int top = (bordered_height_ - shape_.height) / 2;
  const int left = (bordered_width_ - shape_.width) / 2;
  for (int image = 0; image < count; ++image) {
    for (int i = 0; i < shape_.height; ++i, x += line) {
      std::copy_n(x, line,
                  bordered + product(image, bordered_size()) +
                      product((top + i) * bordered_width_ + left, input_pixel_));
    }
  }
}

/// The inverse of add_border().
void Conv2d::take_border(const float* bordered, int count, float* x) const {
  const std::size_t line = product(shape_.width, input_pixel_);
  const int top = (bordered_height_ - shape_.height) / 2;
  const int left = (bordered_width_ - shape_.width) / 2;
  for (int image = 0; image < count; ++image) {
    for (int i = 0; i < shape_.height; ++i, x += line) {
      std::copy_n(bordered + product(image, bordered_size()) +
                      product((top + i) * bordered_width_ + left, input_pixel_),
                  line, x);
    }
  }
}

const float* Conv2d::with_border(const float* x, int count, ConvScratch& scratch) const {
  if (!has_border()) return x;
  const std::size_t size = product(chunk_, bordered_size());
  make_large_enough(scratch.bordered, size);
  std::fill_n(scratch.bordered.data(), size, 0.0f);
  add_border(x, count, scratch.bordered.data());
  return scratch.bordered.data();
}

// --- passes -------------------------------------------------------------------------------------

void Conv2d::forward(std::span<const float> parameters, const float* x, int count,
                     ConvScratch& scratch, float* y) const {
  for (int first = 0; first < count; first += chunk_) {
    const int images = std::min(chunk_, count - first);
    kernels_->multiply({
        .x = with_border(x + product(first, input_size()), images, scratch),
        .x_stride = 0,
        .rows = images * windows(),
        .inner = weight_.rows,
        .weight = parameters.data(),
        .columns = weight_.padded_columns(),
        .start = parameters.data() + weight_.size(),
        .y = y + product(first, output_size()),
        .y_stride = output_pixel(),
        .epilogue = epilogue_of(activation_),
        .windows = {offsets_.data(), shape_.kernel_height, shape_.kernel_width * input_pixel_,
                    bordered_width_ * input_pixel_},
    });
  }
}

void Conv2d::backward(const AlignedArray<float>& transposed, const float* x, const float* y,
                      int count, ConvScratch& scratch, float* dy, std::span<float> gradient,
                      float* dx) const {
  for (int first = 0; first < count; first += chunk_) {
    const int images = std::min(chunk_, count - first);
    float* d = dy + product(first, output_size());
    kernels_->slope({.slope = slope_of(activation_),
                     .d = d,
                     .output = y + product(first, output_size()),
                     .count = product(images, output_size())});
    kernels_->outer({
        .x = with_border(x + product(first, input_size()), images, scratch),
        .x_stride = 0,
        .d = d,
        .d_stride = output_pixel(),
        .rows = images * windows(),
        .inner = weight_.rows,
        .columns = weight_.padded_columns(),
        .gradient = gradient.data(),
        .bias = gradient.data() + weight_.size(),
        .windows = {offsets_.data(), shape_.kernel_height, shape_.kernel_width * input_pixel_,
                    bordered_width_ * input_pixel_},
    });
    if (dx == nullptr) continue;
    backward_to_input(transposed, d, images, scratch, dx + product(first, input_size()));
  }
}

/// The gradient at each window, added to the images, window by window.
void Conv2d::backward_to_input(const AlignedArray<float>& transposed, const float* dy, int count,
                               ConvScratch& scratch, float* dx) const {
  const PanelMatrix turned = weight_.transposed();
  const int stride = turned.padded_columns(), rows = count * windows();
  make_large_enough(scratch.d_windows, product(std::min(kWindowBlock, chunk_ * windows()), stride));
  if (has_border()) make_large_enough(scratch.d_bordered, product(chunk_, bordered_size()));
  float* to = has_border() ? scratch.d_bordered.data() : dx;
  std::fill_n(to, product(count, bordered_size()), 0.0f);
  for (int first = 0; first < rows; first += kWindowBlock) {
    const int block = std::min(kWindowBlock, rows - first);
    kernels_->multiply({
        .x = dy + product(first, output_pixel()),
        .x_stride = output_pixel(),
        .rows = block,
        .inner = turned.rows,
        .weight = transposed.data(),
        .columns = stride,
        .start = nullptr,
        .y = scratch.d_windows.data(),
        .y_stride = stride,
    });
    kernels_->scatter(
        {.from = scratch.d_windows.data(),
         .from_stride = stride,
         .rows = block,
         .x = to,
         .windows = {offsets_.data() + first, shape_.kernel_height,
                     shape_.kernel_width * input_pixel_, bordered_width_ * input_pixel_}});
  }
  if (has_border()) take_border(to, count, dx);
}

// --- policy files -------------------------------------------------------------------------------

PolicyLayer Conv2d::layer(std::span<const float> parameters) const {
  PolicyLayer to;
  to.kind = LayerKind::kConv;
  to.conv = shape_;
  to.inputs = shape_.window_size();
  to.outputs = shape_.outputs;
  to.activation = activation_;
  for (int o = 0; o < to.outputs; ++o) {
    for (int entry = 0; entry < to.inputs; ++entry) {
      to.weight.push_back(static_cast<double>(parameters[weight_index(o, entry)]));
    }
    to.bias.push_back(
        static_cast<double>(parameters[weight_.size() + static_cast<std::size_t>(o)]));
  }
  return to;
}

void Conv2d::set_layer(const PolicyLayer& layer, std::span<float> parameters) const {
  if (layer.kind != LayerKind::kConv || !(layer.conv == shape_) ||
      layer.activation != activation_) {
    throw Error("a policy's convolution differs in size, padding or activation from a network's");
  }
  std::fill_n(parameters.begin(), parameter_count(), 0.0f);
  auto from = layer.weight.begin();
  for (int o = 0; o < layer.outputs; ++o) {
    for (int entry = 0; entry < layer.inputs; ++entry) {
      parameters[weight_index(o, entry)] = static_cast<float>(*from++);
    }
    parameters[weight_.size() + static_cast<std::size_t>(o)] =
        static_cast<float>(layer.bias[static_cast<std::size_t>(o)]);
  }
}

}  // namespace skybody::learn
