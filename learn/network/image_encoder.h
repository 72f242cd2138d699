// Makes features of images: convolutions, then a dense layer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "core/base/simd/isa.h"
#include "core/io/files/policy_file.h"
#include "learn/network/conv2d.h"
#include "learn/network/kernels/kernel_table.h"

namespace skybody::learn {

/// Pixels of an image, row by row, channel by channel. The network sees
/// (clip(pixel, low, high) - low) / (high - low); a pixel that is no number counts as `high`.
struct ImageFormat {
  PixelType type = PixelType::kUint8;
  int height = 0, width = 0, channels = 0;
  float low = 0.0f, high = 255.0f;

  int pixels() const { return height * width * channels; }
  int bytes() const;
};

/// One entry per convolution in `channels`, `kernels` (square) and `strides`.
struct EncoderShape {
  std::vector<int> channels, kernels, strides;
  bool same = false;                          ///< padding, see Conv2d
  int features = 0;                           ///< outputs of the dense layer
  Activation activation = Activation::kRelu;  ///< of every layer
};

/// Memory that forward() fills and backward() reads. One per thread. Only a call with more images
/// than all before allocates.
struct EncoderActivations {
  AlignedArray<float> image;                   ///< scaled pixels
  std::vector<AlignedArray<float>> outputs;    ///< of each layer
  std::vector<AlignedArray<float>> gradients;  ///< at each layer's outputs, of some images
  ConvScratch scratch;
  int rows = 0;  ///< of the last forward()
};

struct TransposedEncoder {
  std::vector<AlignedArray<float>> layers;
};

/// Convolutions, and a dense layer on all their outputs, which is a convolution with one window. It
/// holds no parameters: the parameters are those of the layers, one after another. Results are
/// reproducible as those of Conv2d.
class ImageEncoder {
 public:
  /// @throws Error as Conv2d, or if the lists of `shape` differ in length
  ImageEncoder(const ImageFormat& format, const EncoderShape& shape, Isa isa);

  const ImageFormat& format() const { return format_; }
  int features() const { return layers_.back().shape().outputs; }
  std::size_t parameter_count() const;
  /// Orthogonal weights with gain sqrt(2), zero biases.
  /// @param key,stream  of core/base/math/random.h
  void initialize(std::span<float> parameters, std::uint64_t key, std::uint64_t stream) const;
  /// Updates `transposed`. Call it after every change of the parameters, before backward().
  void transpose(std::span<const float> parameters, TransposedEncoder& transposed) const;

  /// Computes the features of `rows` images.
  /// @param pixels  image r at pixels + index(r) * format().bytes()
  /// @param order   index(r); null: r
  /// @param y       row r at y + r * y_stride
  void forward(std::span<const float> parameters, const std::uint8_t* pixels, const int* order,
               int rows, EncoderActivations& memory, float* y, int y_stride) const;
  /// Adds to `gradient` the gradient by the parameters, from the gradient `dy` at the features of
  /// the last forward().
  /// @param dy  row r at dy + r * dy_stride
  void backward(const TransposedEncoder& transposed, EncoderActivations& memory, const float* dy,
                int dy_stride, std::span<float> gradient) const;

  /// Converts to layers of a policy file.
  std::vector<PolicyLayer> layers(std::span<const float> parameters) const;
  /// Sets parameters from a policy file's layers. @throws Error if they are not of this shape
  void set_layers(std::span<const PolicyLayer> layers, std::span<float> parameters) const;

 private:
  void scale(const std::uint8_t* pixels, const int* order, int first, int rows,
             EncoderActivations& memory) const;
  const float* input_of(std::size_t layer, int first, const EncoderActivations& memory) const;

  ImageFormat format_;
  const KernelTable* kernels_;
  std::vector<Conv2d> layers_;
  std::vector<std::size_t> begins_;  ///< of each layer's parameters
  int chunk_;                        ///< images that go through all layers at once
};

}  // namespace skybody::learn
