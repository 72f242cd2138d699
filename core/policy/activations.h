// Activation functions in double, from bit-stable functions.
#pragma once

#include "core/base/math/math.h"
#include "core/io/files/policy_file.h"

namespace skybody {

/// tanh |x| = (1 - e^(-2|x|)) / (1 + e^(-2|x|)), by expm1 to keep the precision of small x.
inline double tanh_of(double x) {
  const double t = expm1(-2.0 * abs(x));
  return copysign(-t / (t + 2.0), x);
}

inline double activate(double x, Activation activation) {
  switch (activation) {
    case Activation::kTanh:
      return tanh_of(x);
    case Activation::kRelu:
      return x < 0.0 ? 0.0 : x;
    case Activation::kElu:
      return x > 0.0 ? x : expm1(x);
    case Activation::kNone:
      break;
  }
  return x;
}

}  // namespace skybody
