// Layers of a policy's network, in C99 and in float. `skybody run --policy` evaluates them, and
// `skybody export --to c` writes this text into the exported source: both give the same bits.
//
// Needs: IEEE 754 floats, rounded to nearest after each operation (no fused a * b + c, no extended
// precision), subnormal numbers, no -ffast-math. Uses no libm and allocates nothing. NaN gives NaN.
//
// Weights lie in panels of 16 outputs, then of 4, then of 1; a panel holds, for each input, the
// weights of its outputs. Each output's products are summed in blocks of LAYER_BLOCK inputs, from
// the first to the last, and each block's sum is added to the bias in turn: long sums lose less
// precision so, and the width of a panel does not change the bits.
#ifndef SKYBODY_NETWORK_LAYERS_H
#define SKYBODY_NETWORK_LAYERS_H

#include <stdint.h>

#if defined(__FAST_MATH__)
#error "compile without -ffast-math: it changes the bits of the policy's actions"
#endif
#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ != 0
#error "float must be evaluated as float (on 32-bit x86: -msse2 -mfpmath=sse)"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC push_options
// The vectorizer of adjacent statements fuses some products and sums whatever fp-contract is.
#pragma GCC optimize("fp-contract=off", "no-tree-slp-vectorize")
#endif

// --- functions ----------------------------------------------------------------------------------
// The fits are those of learn/network/kernels/functions.h, without fused operations.

/// Within 5 units in the last place (ulp).
static inline float layer_tanh(float x) {
  const float below = 9.02f < x ? 9.02f : x;  // beyond 9.02 the nearest float is 1
  const float a = below < -9.02f ? -9.02f : below;
  const float q = a * a;
  const float numerator =
      (((1.3319194924551621e-08f * q + 2.05835779467487e-05f) * q + 0.003494040763149138f) * q +
       0.1337972327137798f) *
          q +
      0.999999979037096f;
  const float denominator =
      (((7.762072149319023e-07f * q + 0.0003283102756136339f) * q + 0.025871097132413354f) * q +
       0.46713038518437955f) *
          q +
      1.0f;
  const float y = a * numerator / denominator;
  const float least = 1.0f < y ? 1.0f : y;
  return least < -1.0f ? -1.0f : least;
}

/// e^x = power + power * rest for -87 <= x <= 88; beyond them, of the nearest of the two.
typedef struct {
  float power;  ///< of 2
  float rest;
} LayerExponential;

static inline LayerExponential layer_exponential(float x) {
  const float below = 88.0f < x ? 88.0f : x;
  const float a = below < -87.0f ? -87.0f : below;
  // Adding 1.5 * 2^23 rounds to an integer, which is then in the lowest bits.
  union {
    float value;
    uint32_t bits;
  } shifted, power;
  shifted.value = a * 1.44269504088896f + 12582912.0f;
  const float k = shifted.value - 12582912.0f;
  power.bits = (shifted.bits << 23) + 0x3f800000u;
  // ln 2 in two parts. The first has 9 bits, so that its product with k is exact.
  const float r = (a - k * 0.693359375f) + k * 2.12194440054690571e-4f;
  const float p =
      (((0.0013882516413217508f * r + 0.008366547131436145f) * r + 0.04166720071240716f) * r +
       0.16666543424267583f) *
          r +
      0.4999999814961764f;
  const LayerExponential e = {power.value, r * r * p + r};
  return e;
}

/// 1 / (1 + e^-x), within 4 ulp for |x| <= 87.
static inline float layer_sigmoid(float x) {
  const LayerExponential e = layer_exponential(-x);
  return 1.0f / (1.0f + (e.power * e.rest + e.power));
}

/// x for x > 0, else e^x - 1 within 3 ulp.
static inline float layer_elu(float x) {
  if (x > 0.0f) return x;
  const LayerExponential e = layer_exponential(x);
  return e.rest * e.power + (e.power - 1.0f);
}

/// Activations in the order of kActivationNames (core/io/files/policy_file.h).
enum { LAYER_NONE, LAYER_TANH, LAYER_RELU, LAYER_ELU };

static inline void layer_activate(float* values, int count, int activation) {
  int i;
  if (activation == LAYER_TANH) {
    for (i = 0; i < count; ++i) values[i] = layer_tanh(values[i]);
  } else if (activation == LAYER_RELU) {
    for (i = 0; i < count; ++i) values[i] = values[i] < 0.0f ? 0.0f : values[i];
  } else if (activation == LAYER_ELU) {
    for (i = 0; i < count; ++i) values[i] = layer_elu(values[i]);
  }
}

/// value in [low, high]
static inline float layer_clip(float value, float low, float high) {
  const float below = high < value ? high : value;
  return below < low ? low : below;
}

/// An action in [-1, 1] to its range: -1 to low, 1 to high.
static inline float layer_scale(float action, float low, float high) {
  return low + 0.5f * (action + 1.0f) * (high - low);
}

static inline int layer_is_finite(float value) { return value - value == 0.0f; }

// --- sums of products ---------------------------------------------------------------------------

#define LAYER_BLOCK 32

/// Adds a block to the sums of a panel: the products of weight[k * width + j] and x[k] over k = 0
/// ... inputs - 1 to sums[j].
#if defined(__GNUC__) && (defined(__SSE2__) || defined(__aarch64__))
typedef float LayerQuad __attribute__((vector_size(16), aligned(4), may_alias));

static inline void layer_add_products_16(const float* weight, const float* x, int inputs,
                                         float* sums) {
  LayerQuad* const s = (LayerQuad*)sums;
  LayerQuad a = {0.0f, 0.0f, 0.0f, 0.0f}, b = a, c = a, d = a;
  int k;
  for (k = 0; k < inputs; ++k, weight += 16) {
    const LayerQuad* const w = (const LayerQuad*)weight;
    const LayerQuad v = {x[k], x[k], x[k], x[k]};
    a += w[0] * v;
    b += w[1] * v;
    c += w[2] * v;
    d += w[3] * v;
  }
  s[0] += a;
  s[1] += b;
  s[2] += c;
  s[3] += d;
}

static inline void layer_add_products_4(const float* weight, const float* x, int inputs,
                                        float* sums) {
  LayerQuad sum = {0.0f, 0.0f, 0.0f, 0.0f};
  int k;
  for (k = 0; k < inputs; ++k, weight += 4) {
    const LayerQuad v = {x[k], x[k], x[k], x[k]};
    sum += *(const LayerQuad*)weight * v;
  }
  *(LayerQuad*)sums += sum;
}
#else
static inline void layer_add_products_4(const float* weight, const float* x, int inputs,
                                        float* sums) {
  float a = 0.0f, b = 0.0f, c = 0.0f, d = 0.0f;
  int k;
  for (k = 0; k < inputs; ++k, weight += 4) {
    const float v = x[k];
    a += weight[0] * v;
    b += weight[1] * v;
    c += weight[2] * v;
    d += weight[3] * v;
  }
  sums[0] += a;
  sums[1] += b;
  sums[2] += c;
  sums[3] += d;
}

#define LAYER_EACH_16(DO) \
  DO(0)                   \
  DO(1) DO(2) DO(3) DO(4) DO(5) DO(6) DO(7) DO(8) DO(9) DO(10) DO(11) DO(12) DO(13) DO(14) DO(15)
#define LAYER_ZERO(J) float s##J = 0.0f;
#define LAYER_ADD(J) s##J += weight[J] * v;
#define LAYER_STORE(J) sums[J] += s##J;
static inline void layer_add_products_16(const float* weight, const float* x, int inputs,
                                         float* sums) {
  LAYER_EACH_16(LAYER_ZERO)
  int k;
  for (k = 0; k < inputs; ++k, weight += 16) {
    const float v = x[k];
    LAYER_EACH_16(LAYER_ADD)
  }
  LAYER_EACH_16(LAYER_STORE)
}
#endif

static inline void layer_add_products_1(const float* weight, const float* x, int inputs,
                                        float* sums) {
  float sum = 0.0f;
  int k;
  for (k = 0; k < inputs; ++k) sum += weight[k] * x[k];
  *sums += sum;
}

static inline int layer_least(int a, int b) { return a < b ? a : b; }
static inline int layer_greatest(int a, int b) { return a > b ? a : b; }

/// sums += weight x over `inputs` of the panels' inputs: those from `first` on.
/// @param panel_inputs  number of inputs of a panel
static void layer_add_products(const float* weight, int panel_inputs, int first, const float* x,
                               int inputs, float* sums, int outputs) {
  int o = 0, k;
  while (o < outputs) {
    const int rest = outputs - o, width = rest >= 16 ? 16 : rest >= 4 ? 4 : 1;
    for (k = 0; k < inputs; k += LAYER_BLOCK) {
      const float* const w = weight + (first + k) * width;
      const int count = layer_least(LAYER_BLOCK, inputs - k);
      if (width == 16) {
        layer_add_products_16(w, x + k, count, sums + o);
      } else if (width == 4) {
        layer_add_products_4(w, x + k, count, sums + o);
      } else {
        layer_add_products_1(w, x + k, count, sums + o);
      }
    }
    weight += width * panel_inputs;
    o += width;
  }
}

// --- layers -------------------------------------------------------------------------------------

/// to = clip((from - mean) * scale, -clip, clip). The mean has two parts, whose sum is more precise
/// than a float: far from zero its rounding would count.
static inline void layer_normalize(const float* from, const float* mean, const float* mean_rest,
                                   const float* scale, float clip, int count, float* to) {
  int i;
  for (i = 0; i < count; ++i)
    to[i] = layer_clip(((from[i] - mean[i]) - mean_rest[i]) * scale[i], -clip, clip);
}

/// out = activation(weight x + bias)
static inline void layer_dense(const float* weight, const float* bias, int inputs, int outputs,
                               int activation, const float* x, float* out) {
  int o;
  for (o = 0; o < outputs; ++o) out[o] = bias[o];
  layer_add_products(weight, inputs, 0, x, inputs, out, outputs);
  layer_activate(out, outputs, activation);
}

/// Gated recurrent units (policy_file.h): computes the next state, which is also the output.
/// @param sums  6 * units values of work space
static inline void layer_gru(const float* weight, const float* bias, const float* state_weight,
                             const float* state_bias, int inputs, int units, const float* x,
                             float* state, float* sums) {
  float* const from_state = sums + 3 * units;
  int u;
  layer_dense(weight, bias, inputs, 3 * units, LAYER_NONE, x, sums);
  layer_dense(state_weight, state_bias, units, 3 * units, LAYER_NONE, state, from_state);
  for (u = 0; u < units; ++u) {
    const float reset = layer_sigmoid(sums[u] + from_state[u]);
    const float update = layer_sigmoid(sums[units + u] + from_state[units + u]);
    const float candidate = layer_tanh(sums[2 * units + u] + reset * from_state[2 * units + u]);
    state[u] = candidate + update * (state[u] - candidate);
  }
}

/// Long short-term memory (policy_file.h): computes the next state, `units` outputs and then as
/// many cells.
/// @param sums  8 * units values of work space
static inline void layer_lstm(const float* weight, const float* bias, const float* state_weight,
                              const float* state_bias, int inputs, int units, const float* x,
                              float* state, float* sums) {
  float* const from_state = sums + 4 * units;
  float* const cells = state + units;
  int u;
  layer_dense(weight, bias, inputs, 4 * units, LAYER_NONE, x, sums);
  layer_dense(state_weight, state_bias, units, 4 * units, LAYER_NONE, state, from_state);
  for (u = 0; u < 4 * units; ++u) sums[u] += from_state[u];
  for (u = 0; u < units; ++u) {
    const float in = layer_sigmoid(sums[u]) * layer_tanh(sums[2 * units + u]);
    cells[u] = layer_sigmoid(sums[units + u]) * cells[u] + in;
    state[u] = layer_sigmoid(sums[3 * units + u]) * layer_tanh(cells[u]);
  }
}

/// Sizes of a convolution; `top` and `left` are the rows and columns of zeros before the image.
typedef struct {
  int height, width, channels;  ///< of the input
  int kernel_height, kernel_width, stride;
  int top, left;
  int out_height, out_width, outputs;
} LayerConvolution;

/// One window: out = weight x + bias, where `row` and `column` are its first ones in the image.
static inline void layer_window(const LayerConvolution* s, const float* weight, const float* bias,
                                const float* image, int row, int column, float* out) {
  const int panel_inputs = s->kernel_height * s->kernel_width * s->channels;
  const int begin = layer_greatest(0, -column);
  const int inputs = (layer_least(s->kernel_width, s->width - column) - begin) * s->channels;
  const int end_row = layer_least(s->kernel_height, s->height - row);
  int r, o;
  for (o = 0; o < s->outputs; ++o) out[o] = bias[o];
  for (r = layer_greatest(0, -row); r < end_row; ++r) {
    layer_add_products(weight, panel_inputs, (r * s->kernel_width + begin) * s->channels,
                       image + ((row + r) * s->width + column + begin) * s->channels, inputs, out,
                       s->outputs);
  }
}

/// Values of images lie row by row, pixel by pixel, channel by channel.
static inline void layer_convolve(const LayerConvolution* s, const float* weight, const float* bias,
                                  int activation, const float* image, float* out) {
  float* to = out;
  int i, j;
  for (i = 0; i < s->out_height; ++i) {
    for (j = 0; j < s->out_width; ++j, to += s->outputs)
      layer_window(s, weight, bias, image, i * s->stride - s->top, j * s->stride - s->left, to);
  }
  layer_activate(out, s->out_height * s->out_width * s->outputs, activation);
}

/// A pixel in [low, high] to 0 ... 1. One that is no number counts as `high`.
static inline float layer_pixel(float pixel, float low, float high) {
  const float below = pixel < high ? pixel : high;
  return ((below > low ? below : low) - low) * (1.0f / (high - low));
}

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC pop_options
#endif

#endif
