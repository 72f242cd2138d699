#include "learn/network/initial_weights.h"

#include <algorithm>

#include "core/base/math/math.h"
#include "core/base/math/random.h"

namespace skybody::learn {
namespace {

constexpr std::size_t kLanes = 8;

/// Uses eight partial sums, which the compiler keeps in lanes, added in order.
double dot(const double* a, const double* b, std::size_t count) {
  double sums[kLanes] = {};
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) sums[k] += a[i + k] * b[i + k];
  }
  double sum = 0.0;
  for (const double s : sums) sum += s;
  for (; i < count; ++i) sum += a[i] * b[i];
  return sum;
}

/// Removes from `vector` its components along `count` orthonormal vectors. Two passes are enough
/// (Giraud, Langou and Rozloznik 2005).
void make_orthogonal(const double* others, std::size_t count, std::size_t size, double* vector) {
  for (int pass = 0; pass < 2; ++pass) {
    for (std::size_t k = 0; k < count; ++k) {
      const double* other = others + k * size;
      const double along = dot(other, vector, size);
      for (std::size_t i = 0; i < size; ++i) vector[i] -= along * other[i];
    }
  }
}

}  // namespace

std::vector<double> orthogonal_matrix(int rows, int columns, const WeightSource& source) {
  const auto count = static_cast<std::size_t>(std::min(rows, columns));
  const auto size = static_cast<std::size_t>(std::max(rows, columns));
  Random<double> random({source.key, 0}, 0, source.step, source.stream);
  std::vector<double> vectors(count * size);
  for (std::size_t k = 0; k < count; ++k) {
    double* vector = vectors.data() + k * size;
    for (std::size_t i = 0; i < size; ++i) vector[i] = random.normal();
    make_orthogonal(vectors.data(), k, size, vector);
    const double scale = 1.0 / sqrt(dot(vector, vector, size));
    for (std::size_t i = 0; i < size; ++i) vector[i] *= scale;
  }
  if (rows <= columns) return vectors;
  std::vector<double> turned(vectors.size());
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t i = 0; i < size; ++i) turned[i * count + k] = vectors[k * size + i];
  }
  return turned;
}

}  // namespace skybody::learn
