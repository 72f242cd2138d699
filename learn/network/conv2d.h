// A convolution of images: forward pass and gradient.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "core/base/simd/isa.h"
#include "core/io/files/policy_file.h"
#include "learn/network/initial_weights.h"
#include "learn/network/panel_matrix.h"

namespace skybody::learn {

struct KernelTable;

/// Memory that Conv2d's calls use. One per thread; only a call with more images than all before
/// allocates.
struct ConvScratch {
  AlignedArray<float> bordered;    ///< inputs with the zeros of `same` around them
  AlignedArray<float> d_bordered;  ///< gradient at these
  AlignedArray<float> d_windows;   ///< gradient at some windows
};

/// A convolution, as PyTorch's Conv2d computes it (a cross-correlation):
///   y[i, j, o] = activation(bias[o] + sum of weight[r, c, k, o] x[i stride + r, j stride + c, k]).
///
/// Padding `valid` has windows inside of the image only. `same` has ceil(size / stride) windows in
/// each direction, with zeros around the image, on either side half of them, the odd one at the end
/// (as TensorFlow).
///
/// An image in memory is height x width pixels, row by row, without gaps. A pixel of the input has
/// input_pixel() floats, one of the output output_pixel(); those beyond the channels are zero.
/// Parameters are an array of the caller: the weight in the layout of PanelMatrix, one row for each
/// (r, c, k) of a window in this order, one column for each output; then the bias. Sums run over
/// the rows of the weight in order, with fused multiply-add; those of a gradient over images and
/// their windows in order. So the bits are the same on v3 and v4, and for any split of images into
/// calls.
class Conv2d {
 public:
  /// @param input_pixel  floats of an input pixel, at least its channels
  /// @throws Error if a size is not in 1..2^20, the kernel is larger than an image (`valid`), or an
  ///         image or a weight has more than 2^24 values
  Conv2d(const ConvShape& shape, int input_pixel, Activation activation, Isa isa);

  const ConvShape& shape() const { return shape_; }
  Activation activation() const { return activation_; }
  int input_pixel() const { return input_pixel_; }
  int output_pixel() const { return weight_.padded_columns(); }
  /// Floats of an image.
  int input_size() const { return shape_.height * shape_.width * input_pixel_; }
  int output_size() const { return windows() * output_pixel(); }
  std::size_t parameter_count() const;

  /// Orthogonal weights times `gain`, zero biases.
  void initialize(std::span<float> parameters, double gain, const WeightSource& source) const;
  /// Updates `transposed`. Call it after every change of the parameters, before backward().
  void transpose(std::span<const float> parameters, AlignedArray<float>& transposed) const;

  /// Computes `count` output images.
  /// @param x,y  images one after another
  void forward(std::span<const float> parameters, const float* x, int count, ConvScratch& scratch,
               float* y) const;
  /// Adds to `gradient` the gradient by the parameters.
  /// @param x,y  input and output of forward()
  /// @param dy   the gradient at y; overwritten
  /// @param dx   null, or output: the gradient at x
  void backward(const AlignedArray<float>& transposed, const float* x, const float* y, int count,
                ConvScratch& scratch, float* dy, std::span<float> gradient, float* dx) const;

  /// Converts to a layer of a policy file.
  PolicyLayer layer(std::span<const float> parameters) const;
  /// Sets parameters from a policy file's layer. @throws Error if the layer is not of this shape
  void set_layer(const PolicyLayer& layer, std::span<float> parameters) const;

 private:
  int windows() const { return shape_.out_height() * shape_.out_width(); }
  bool has_border() const;
  int bordered_size() const { return bordered_height_ * bordered_width_ * input_pixel_; }
  void add_border(const float* x, int count, float* bordered) const;
  void take_border(const float* bordered, int count, float* x) const;
  const float* with_border(const float* x, int count, ConvScratch& scratch) const;
  void backward_to_input(const AlignedArray<float>& transposed, const float* dy, int count,
                         ConvScratch& scratch, float* dx) const;
  std::size_t weight_index(int output, int entry) const;

  ConvShape shape_;
  int input_pixel_;
  Activation activation_;
  const KernelTable* kernels_;
  PanelMatrix weight_;
  int bordered_height_, bordered_width_;
  int chunk_;                          ///< images per call of a kernel
  std::vector<std::int32_t> offsets_;  ///< of the windows of `chunk_` images
};

}  // namespace skybody::learn
