// Distributions of one number, for randomizers and requests, sampled by the inverse of the
// cumulative distribution. On double and packs.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/base/math/math.h"
#include "core/base/math/math_normal.h"
#include "core/base/system/number_text.h"

namespace skybody {

enum class DistributionKind {
  kConstant,    ///< always `low`
  kUniform,     ///< between low and high
  kLogUniform,  ///< its logarithm is uniform; low > 0
  kNormal,      ///< with a mean and a deviation, truncated to [low, high]
  kChoice       ///< one of `values`, by `weights`
};

/// A distribution of one number in any unit. Create it with the functions below: they check it.
struct Distribution {
  DistributionKind kind = DistributionKind::kConstant;
  double low = 0.0, high = 0.0;        ///< inclusive bounds of the values
  double mean = 0.0, deviation = 0.0;  ///< kNormal: before truncation
  double from = 0.0, share = 1.0;      ///< kNormal: probability below low; between low and high
  std::vector<double> values;          ///< kChoice
  std::vector<double> weights;         ///< kChoice: one per value, adding up to 1
  std::vector<double> sums;            ///< kChoice: cumulative sums of the weights

  /// The inverse of the cumulative distribution.
  /// @param u  0 <= u < 1
  template <class Real>
  SKYBODY_INLINE Real at(const Real& u) const {
    switch (kind) {
      case DistributionKind::kUniform:
        return low + (high - low) * u;
      case DistributionKind::kLogUniform:
        return clamp(low * exp(u * log(high / low)), Real(low), Real(high));
      case DistributionKind::kNormal:
        return clamp(mean + deviation * normal_quantile(from + share * u), Real(low), Real(high));
      case DistributionKind::kChoice: {
        Real value(values.back());
        for (std::size_t k = values.size() - 1; k-- > 0;) {
          value = select(u < sums[k], Real(values[k]), value);
        }
        return value;
      }
      case DistributionKind::kConstant:
        break;
    }
    return Real(low);
  }
};

namespace detail {

inline void check_distribution_range(double low, double high) {
  if (!(low <= high)) {
    throw std::runtime_error("the range [" + to_text(low) + ", " + to_text(high) +
                             "] runs backwards: write [low, high]");
  }
}

}  // namespace detail

inline Distribution make_constant(double value) {
  Distribution d;
  d.low = d.high = value;
  return d;
}

/// @throws std::runtime_error if low > high
inline Distribution make_uniform(double low, double high) {
  detail::check_distribution_range(low, high);
  Distribution d;
  d.kind = DistributionKind::kUniform;
  d.low = low;
  d.high = high;
  return d;
}

/// @throws std::runtime_error if low > high, or low <= 0
inline Distribution make_log_uniform(double low, double high) {
  detail::check_distribution_range(low, high);
  if (!(low > 0.0)) {
    throw std::runtime_error("log_uniform needs a range above 0, and this one begins at " +
                             to_text(low) + ": raise it, or take uniform");
  }
  Distribution d = make_uniform(low, high);
  d.kind = DistributionKind::kLogUniform;
  return d;
}

/// A normal distribution truncated to [low, high], as if values outside were drawn again.
/// @throws std::runtime_error if low >= high, deviation <= 0, or its probability between low and
///         high is below one millionth
inline Distribution make_normal(double mean, double deviation, double low, double high) {
  detail::check_distribution_range(low, high);
  if (!(deviation > 0.0)) {
    throw std::runtime_error("the deviation is " + to_text(deviation) +
                             ": allowed are values above 0; for one value take a choice");
  }
  Distribution d = make_uniform(low, high);
  d.kind = DistributionKind::kNormal;
  d.mean = mean;
  d.deviation = deviation;
  d.from = normal_cdf((low - mean) / deviation);
  d.share = normal_cdf((high - mean) / deviation) - d.from;
  if (!(d.share >= 1e-6)) {
    throw std::runtime_error("the range [" + to_text(low) + ", " + to_text(high) +
                             "] holds less than a millionth of the normal distribution: move it "
                             "nearer to the mean " +
                             to_text(mean));
  }
  return d;
}

/// @param weights  one per value, above 0, adding up to 1; empty: equal weights
/// @throws std::runtime_error if there is no value, or the weights do not meet these conditions
inline Distribution make_choice(std::vector<double> values, std::vector<double> weights = {}) {
  if (values.empty()) throw std::runtime_error("a choice needs at least one value");
  if (weights.empty()) weights.assign(values.size(), 1.0 / static_cast<double>(values.size()));
  if (weights.size() != values.size()) {
    throw std::runtime_error("there are " + std::to_string(values.size()) + " values and " +
                             std::to_string(weights.size()) + " weights: give one for each");
  }
  Distribution d;
  d.kind = DistributionKind::kChoice;
  double sum = 0.0;
  d.low = d.high = values[0];
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!(weights[k] > 0.0)) {
      throw std::runtime_error("the weight " + to_text(weights[k]) +
                               " is not above 0: leave its value out");
    }
    sum += weights[k];
    d.sums.push_back(sum);
    d.low = min(d.low, values[k]);
    d.high = max(d.high, values[k]);
  }
  if (!(abs(sum - 1.0) < 1e-9)) {
    throw std::runtime_error("the weights add up to " + to_text(sum) +
                             ": allowed is 1; scale them");
  }
  d.values = std::move(values);
  d.weights = std::move(weights);
  return d;
}

}  // namespace skybody
