// Activations of layers as functions of the kernels.
#pragma once

#include "core/io/files/policy_file.h"
#include "learn/network/kernels/kernel_table.h"

namespace skybody::learn {

inline Finish finish_of(Activation activation) {
  switch (activation) {
    case Activation::kTanh:
      return Finish::kTanh;
    case Activation::kRelu:
      return Finish::kRelu;
    case Activation::kElu:
      return Finish::kElu;
    case Activation::kNone:
      break;
  }
  return Finish::kNone;
}

/// The derivative, as a function of the output.
inline Finish slope_of(Activation activation) {
  switch (activation) {
    case Activation::kTanh:
      return Finish::kTanhSlope;
    case Activation::kRelu:
      return Finish::kReluSlope;
    case Activation::kElu:
      return Finish::kEluSlope;
    case Activation::kNone:
      break;
  }
  return Finish::kNone;
}

}  // namespace skybody::learn
