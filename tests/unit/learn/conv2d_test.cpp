// The oracle is a convolution in double, written index by index. Finite differences check the
// oracle's gradient; tests/oracle/test_networks.py compares with PyTorch.
#include "learn/network/conv2d.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/math/hash.h"
#include "core/base/system/error.h"
#include "core/policy/image_features.h"
#include "learn/network/image_encoder.h"
#include "tests/unit/learn/isas.h"

namespace skybody::learn {
namespace {

using Values = std::vector<double>;

double activate(double x, Activation activation) {
  if (activation == Activation::kTanh) return std::tanh(x);
  if (activation == Activation::kRelu) return std::max(x, 0.0);
  if (activation == Activation::kElu) return x > 0.0 ? x : std::expm1(x);
  return x;
}

double slope(double y, Activation activation) {
  if (activation == Activation::kTanh) return 1.0 - y * y;
  if (activation == Activation::kRelu) return y > 0.0 ? 1.0 : 0.0;
  if (activation == Activation::kElu) return y > 0.0 ? 1.0 : y + 1.0;
  return 1.0;
}

/// The first row or column of a window, before the image if there is padding.
int first_of(int window, int size, int kernel, int windows, const ConvShape& shape) {
  const int missing = std::max(0, (windows - 1) * shape.stride + kernel - size);
  return window * shape.stride - (shape.same ? missing / 2 : 0);
}

/// Calls visit(output value, weight, input value) with the index of each.
template <class Visit>
void for_each_product(const ConvShape& s, const Visit& visit) {
  for (int i = 0; i < s.out_height(); ++i) {
    for (int j = 0; j < s.out_width(); ++j) {
      const int top = first_of(i, s.height, s.kernel_height, s.out_height(), s);
      const int left = first_of(j, s.width, s.kernel_width, s.out_width(), s);
      for (int r = 0; r < s.kernel_height; ++r) {
        for (int c = 0; c < s.kernel_width; ++c) {
          const int y = top + r, x = left + c;
          if (y < 0 || y >= s.height || x < 0 || x >= s.width) continue;
          for (int k = 0; k < s.channels; ++k) {
            for (int o = 0; o < s.outputs; ++o) {
              visit((i * s.out_width() + j) * s.outputs + o,
                    ((o * s.kernel_height + r) * s.kernel_width + c) * s.channels + k,
                    (y * s.width + x) * s.channels + k);
            }
          }
        }
      }
    }
  }
}

struct Answer {
  Values y, dx;
  PolicyLayer gradient;
};

/// The oracle's results for one image: outputs, and gradients of sum(y * dy).
Answer reference(const PolicyLayer& layer, const Values& x, const Values& dy) {
  const ConvShape& s = layer.conv;
  Answer answer{Values(s.output_size()), Values(x.size()), layer};
  for (std::size_t i = 0; i < answer.y.size(); ++i) answer.y[i] = layer.bias[i % s.outputs];
  for_each_product(s, [&](int y, int w, int from) { answer.y[y] += layer.weight[w] * x[from]; });
  Values d(answer.y.size());
  std::fill(answer.gradient.weight.begin(), answer.gradient.weight.end(), 0.0);
  std::fill(answer.gradient.bias.begin(), answer.gradient.bias.end(), 0.0);
  for (std::size_t i = 0; i < d.size(); ++i) {
    answer.y[i] = activate(answer.y[i], layer.activation);
    d[i] = dy[i] * slope(answer.y[i], layer.activation);
    answer.gradient.bias[i % s.outputs] += d[i];
  }
  for_each_product(s, [&](int y, int w, int from) {
    answer.gradient.weight[w] += d[y] * x[from];
    answer.dx[from] += d[y] * layer.weight[w];
  });
  return answer;
}

Values normals(std::size_t count, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<float> normal;
  Values values(count);
  for (double& value : values) value = static_cast<double>(normal(generator));
  return values;
}

/// Images with `from` values per pixel, of which pixels of `to` floats are made.
std::vector<float> spread(const Values& values, int from, int to) {
  std::vector<float> result(values.size() / from * to);
  for (std::size_t i = 0; i < values.size(); ++i) {
    result[i / from * to + i % from] = static_cast<float>(values[i]);
  }
  return result;
}

struct Subject {
  Conv2d conv;
  std::vector<float> parameters, gradient, y, dx;
  AlignedArray<float> transposed;
  ConvScratch scratch;

  Subject(const ConvShape& shape, Activation activation, Isa isa)
      : conv(shape, shape.channels + 2, activation, isa),
        parameters(conv.parameter_count()),
        gradient(conv.parameter_count()) {
    conv.initialize(parameters, 1.0, {5, 7, 0});
    PolicyLayer layer = conv.layer(parameters);
    for (int o = 0; o < shape.outputs; ++o) layer.bias[o] = 0.1 * ((o % 7) - 3);
    conv.set_layer(layer, parameters);
    conv.transpose(parameters, transposed);
  }

  void run(const Values& x, const Values& dy, int images) {
    const ConvShape& s = conv.shape();
    const std::vector<float> input = spread(x, s.channels, conv.input_pixel());
    std::vector<float> d = spread(dy, s.outputs, conv.output_pixel());
    y.assign(static_cast<std::size_t>(images * conv.output_size()), 77.0f);
    dx.assign(input.size(), 77.0f);
    conv.forward(parameters, input.data(), images, scratch, y.data());
    conv.backward(transposed, input.data(), y.data(), images, scratch, d.data(), gradient,
                  dx.data());
  }
};

constexpr ConvShape kShapes[] = {
    {.height = 1, .width = 1, .channels = 1, .outputs = 1, .kernel_height = 1, .kernel_width = 1},
    {.height = 5, .width = 7, .channels = 3, .outputs = 17, .kernel_height = 2, .kernel_width = 3},
    {.height = 12,
     .width = 9,
     .channels = 1,
     .outputs = 16,
     .kernel_height = 4,
     .kernel_width = 4,
     .stride = 3},
    {.height = 6,
     .width = 6,
     .channels = 16,
     .outputs = 70,
     .kernel_height = 3,
     .kernel_width = 3,
     .same = true},
    {.height = 9,
     .width = 8,
     .channels = 2,
     .outputs = 33,
     .kernel_height = 4,
     .kernel_width = 3,
     .stride = 2,
     .same = true},
    {.height = 4, .width = 5, .channels = 40, .outputs = 20, .kernel_height = 4, .kernel_width = 5},
    {.height = 7,
     .width = 7,
     .channels = 3,
     .outputs = 4,
     .kernel_height = 2,
     .kernel_width = 2,
     .stride = 5,
     .same = true},
};

/// Float sums of n terms of size s have errors of about sqrt(n) s 2^-24; 30 of these are allowed.
void expect_near(const std::vector<float>& values, const Values& wanted, int from, int to,
                 double scale, const char* what) {
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    ASSERT_NEAR(static_cast<double>(values[i / from * to + i % from]), wanted[i], 2e-6 * scale)
        << what << " " << i;
  }
}

void expect_as_reference(const ConvShape& s, Activation activation, int images, Isa isa) {
  SCOPED_TRACE(std::string(name(isa)) + ", " + std::to_string(s.height) + " x " +
               std::to_string(s.width) + ", images " + std::to_string(images));
  Subject subject(s, activation, isa);
  const std::size_t size = s.height * s.width * s.channels, out = s.output_size();
  const Values x = normals(images * size, 1), dy = normals(images * out, 2);
  subject.run(x, dy, images);
  const PolicyLayer layer = subject.conv.layer(subject.parameters);
  PolicyLayer total = layer;
  std::fill(total.weight.begin(), total.weight.end(), 0.0);
  std::fill(total.bias.begin(), total.bias.end(), 0.0);
  Values y, dx;
  for (int k = 0; k < images; ++k) {
    const Answer one = reference(layer, Values(x.begin() + k * size, x.begin() + (k + 1) * size),
                                 Values(dy.begin() + k * out, dy.begin() + (k + 1) * out));
    y.insert(y.end(), one.y.begin(), one.y.end());
    dx.insert(dx.end(), one.dx.begin(), one.dx.end());
    for (std::size_t i = 0; i < total.weight.size(); ++i) total.weight[i] += one.gradient.weight[i];
    for (std::size_t i = 0; i < total.bias.size(); ++i) total.bias[i] += one.gradient.bias[i];
  }
  const double windows = images * s.out_height() * s.out_width();
  expect_near(subject.y, y, s.outputs, subject.conv.output_pixel(), 10.0, "output");
  expect_near(subject.dx, dx, s.channels, subject.conv.input_pixel(), 40.0, "dx");
  const PolicyLayer gradient = subject.conv.layer(subject.gradient);
  for (std::size_t i = 0; i < total.weight.size(); ++i) {
    ASSERT_NEAR(gradient.weight[i], total.weight[i], 2e-5 * windows) << "weight " << i;
  }
  for (std::size_t i = 0; i < total.bias.size(); ++i) {
    ASSERT_NEAR(gradient.bias[i], total.bias[i], 2e-5 * windows) << "bias " << i;
  }
}

/// Central differences of the oracle itself.
TEST(ConvReference, HasTheGradientOfFiniteDifferences) {
  const ConvShape& s = kShapes[4];
  Subject subject(s, Activation::kTanh, best_isa());
  PolicyLayer layer = subject.conv.layer(subject.parameters);
  Values x = normals(s.height * s.width * s.channels, 1);
  const Values dy = normals(s.output_size(), 2);
  const Answer answer = reference(layer, x, dy);
  const auto loss = [&] {
    const Values y = reference(layer, x, dy).y;
    double sum = 0.0;
    for (std::size_t i = 0; i < y.size(); ++i) sum += y[i] * dy[i];
    return sum;
  };
  const auto expect_slope = [&](double& value, double wanted) {
    const double kept = value, step = 1e-5;
    value = kept + step;
    const double above = loss();
    value = kept - step;
    const double below = loss();
    value = kept;
    // Truncation of order step^2, cancellation of order 1e-15 / step.
    ASSERT_NEAR((above - below) / (2.0 * step), wanted, 1e-7);
  };
  for (std::size_t i = 0; i < 100; ++i) {
    expect_slope(layer.weight[i], answer.gradient.weight[i]);
    expect_slope(x[i], answer.dx[i]);
  }
}

TEST(Conv2d, IsTheReferenceForAnySizesAndPadding) {
  for (const Isa isa : isas()) {
    for (const ConvShape& shape : kShapes) expect_as_reference(shape, Activation::kElu, 3, isa);
  }
}

TEST(Conv2d, IsTheReferenceForEveryActivationAndOverSeveralChunks) {
  for (const Activation activation : {Activation::kTanh, Activation::kRelu, Activation::kNone}) {
    expect_as_reference(kShapes[3], activation, 41, best_isa());
  }
}

/// A kernel of ones counts the pixels in each window; with zeros around the image those inside.
TEST(Conv2d, CountsThePixelsInsideOfEachWindow) {
  for (const bool same : {false, true}) {
    const ConvShape s = {.height = 4,
                         .width = 4,
                         .channels = 1,
                         .outputs = 1,
                         .kernel_height = 3,
                         .kernel_width = 3,
                         .same = same};
    Subject subject(s, Activation::kNone, best_isa());
    PolicyLayer layer = subject.conv.layer(subject.parameters);
    std::fill(layer.weight.begin(), layer.weight.end(), 1.0);
    layer.bias[0] = 0.0;
    subject.conv.set_layer(layer, subject.parameters);
    subject.run(Values(16, 1.0), Values(s.output_size()), 1);
    const std::vector<float> wanted =
        same ? std::vector<float>{4, 6, 6, 4, 6, 9, 9, 6, 6, 9, 9, 6, 4, 6, 6, 4}
             : std::vector<float>{9, 9, 9, 9};
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      EXPECT_EQ(subject.y[i * subject.conv.output_pixel()], wanted[i]) << i;
    }
  }
}

TEST(Conv2d, HasAsManyWindowsAsTensorFlow) {
  ConvShape s = {.height = 64,
                 .width = 48,
                 .channels = 1,
                 .outputs = 1,
                 .kernel_height = 8,
                 .kernel_width = 8,
                 .stride = 4};
  EXPECT_EQ(s.out_height(), 15);
  EXPECT_EQ(s.out_width(), 11);
  s.same = true;
  EXPECT_EQ(s.out_height(), 16);
  EXPECT_EQ(s.out_width(), 12);
}

TEST(Conv2d, LeavesPaddingOfOutputsParametersAndGradientsAtZero) {
  Subject subject(kShapes[1], Activation::kElu, best_isa());
  const ConvShape& s = subject.conv.shape();
  subject.run(normals(2 * s.height * s.width * s.channels, 1), normals(2 * s.output_size(), 2), 2);
  std::vector<float> again(subject.gradient.size());
  subject.conv.set_layer(subject.conv.layer(subject.gradient), again);
  EXPECT_EQ(again, subject.gradient);
  for (std::size_t i = 0; i < subject.y.size(); ++i) {
    if (static_cast<int>(i) % subject.conv.output_pixel() >= s.outputs) {
      ASSERT_EQ(subject.y[i], 0.0f);
    }
  }
}

TEST(Conv2d, RefusesShapesThatAreNone) {
  ConvShape s = kShapes[1];
  s.kernel_height = 6;
  EXPECT_THROW(Conv2d(s, 3, Activation::kTanh, best_isa()), Error) << "larger than the image";
  s = kShapes[1];
  s.stride = 0;
  EXPECT_THROW(Conv2d(s, 3, Activation::kTanh, best_isa()), Error);
}

// --- encoder ------------------------------------------------------------------------------------

constexpr ImageFormat kGrey = {PixelType::kUint8, 36, 40, 1, 0.0f, 255.0f};
const EncoderShape kEncoder = {{16, 20, 32}, {8, 4, 3}, {4, 2, 1}, false, 50, Activation::kTanh};

std::vector<std::uint8_t> random_bytes(std::size_t count) {
  std::mt19937 generator(3);
  std::vector<std::uint8_t> bytes(count);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(generator());
  return bytes;
}

struct EncoderRun {
  std::vector<float> y, gradient;
};

/// Features and gradient of some images, in calls of at most `at_most`.
EncoderRun run(const EncoderShape& shape, Isa isa, int rows, int at_most) {
  const ImageEncoder encoder(kGrey, shape, isa);
  std::vector<float> parameters(encoder.parameter_count());
  encoder.initialize(parameters, 5, 7);
  TransposedEncoder transposed;
  encoder.transpose(parameters, transposed);
  const std::vector<std::uint8_t> bytes = random_bytes(rows * kGrey.bytes());
  EncoderRun result{std::vector<float>(rows * shape.features),
                    std::vector<float>(parameters.size())};
  EncoderActivations memory;
  for (int first = 0; first < rows; first += at_most) {
    float* y = result.y.data() + first * shape.features;
    encoder.forward(parameters, bytes.data() + first * kGrey.bytes(), nullptr,
                    std::min(at_most, rows - first), memory, y, shape.features);
    encoder.backward(transposed, memory, y, shape.features, result.gradient);
  }
  return result;
}

TEST(ImageEncoder, GivesTheSameBitsForAnySplitOfTheImages) {
  for (const Isa isa : isas()) {
    const EncoderRun whole = run(kEncoder, isa, 70, 70);
    for (const int at_most : {1, 9, 33}) {
      const EncoderRun split = run(kEncoder, isa, 70, at_most);
      EXPECT_EQ(whole.y, split.y) << name(isa) << " " << at_most;
      EXPECT_EQ(whole.gradient, split.gradient) << name(isa) << " " << at_most;
    }
  }
}

TEST(ImageEncoder, GivesTheSameBitsOnEverySetWithFusedMultiplyAdd) {
  const std::vector<Isa> sets = fused_isas();
  if (sets.size() < 2) GTEST_SKIP() << "this machine has " << machine_isas();
  EncoderShape shape = kEncoder;
  for (const bool same : {false, true}) {
    shape.same = same;
    EXPECT_EQ(run(shape, sets[0], 19, 19).y, run(shape, sets[1], 19, 19).y);
    EXPECT_EQ(run(shape, sets[0], 19, 19).gradient, run(shape, sets[1], 19, 19).gradient);
  }
}

/// Changes with the arithmetic of convolutions.
TEST(ImageEncoder, HasTheGoldenHash) {
  if (fused_isas().empty()) GTEST_SKIP() << "without fused multiply-add the last bits are others";
  for (const Isa isa : fused_isas()) {
    const EncoderRun result = run(kEncoder, isa, 21, 21);
    HashChain chain;
    chain.update(hash_bytes(result.y.data(), result.y.size() * sizeof(float)));
    chain.update(hash_bytes(result.gradient.data(), result.gradient.size() * sizeof(float)));
    EXPECT_EQ(to_hex(chain.value()), "6152658957050ff2") << name(isa);
  }
}

/// Pixels of every type that show the same image give the same features.
TEST(ImageEncoder, ScalesPixelsOfEveryTypeToTheirRange) {
  const ImageFormat formats[] = {{PixelType::kUint8, 2, 3, 1, 0.0f, 200.0f},
                                 {PixelType::kUint16, 2, 3, 1, 1000.0f, 21000.0f},
                                 {PixelType::kFloat32, 2, 3, 1, -1.0f, 1.0f}};
  const std::vector<std::uint8_t> bytes = {0, 50, 100, 200, 255, 200};  // 255 is clipped
  const std::vector<std::uint16_t> words = {0, 6000, 11000, 21000, 65535, 21000};
  const std::vector<float> floats = {-7.0f, -0.5f, 0.0f, 1.0f, INFINITY, std::nanf("")};
  const void* images[] = {bytes.data(), words.data(), floats.data()};
  const EncoderShape shape = {{}, {}, {}, false, 6, Activation::kNone};
  for (int k = 0; k < 3; ++k) {
    const ImageEncoder encoder(formats[k], shape, best_isa());
    std::vector<float> parameters(encoder.parameter_count());
    std::vector<PolicyLayer> layers = encoder.layers(parameters);
    for (int i = 0; i < 6; ++i) layers[0].weight[i * 6 + i] = 1.0;
    encoder.set_layers(layers, parameters);
    EncoderActivations memory;
    std::vector<float> y(6);
    encoder.forward(parameters, static_cast<const std::uint8_t*>(images[k]), nullptr, 1, memory,
                    y.data(), 6);
    const float wanted[] = {0.0f, 0.25f, 0.5f, 1.0f, 1.0f, 1.0f};
    for (int i = 0; i < 6; ++i) EXPECT_FLOAT_EQ(y[i], wanted[i]) << k << " " << i;
  }
}

/// A policy file's layers against the learner's: floats, sums of up to 1,500 terms, ordered
/// differently.
TEST(ImageEncoder, GivesThePolicyFilesFeatures) {
  EncoderShape shape = kEncoder;
  for (const bool same : {false, true}) {
    shape.same = same;
    const ImageEncoder encoder(kGrey, shape, best_isa());
    std::vector<float> parameters(encoder.parameter_count()), y(50);
    encoder.initialize(parameters, 5, 7);
    const std::vector<std::uint8_t> bytes = random_bytes(kGrey.bytes());
    EncoderActivations memory;
    encoder.forward(parameters, bytes.data(), nullptr, 1, memory, y.data(), 50);
    ImageFeatures features({"", 36, 40, 1, 0.0, 255.0, encoder.layers(parameters)});
    std::vector<float> wanted(50);
    features.evaluate(ColumnType::kUint8, bytes.data(), wanted.data());
    for (int i = 0; i < 50; ++i) EXPECT_NEAR(y[i], wanted[i], 1e-5f) << i;
  }
}

TEST(ImageEncoder, RefusesListsOfDifferentLengths) {
  EncoderShape shape = kEncoder;
  shape.strides.pop_back();
  EXPECT_THROW(ImageEncoder(kGrey, shape, best_isa()), Error);
}

}  // namespace
}  // namespace skybody::learn
