// Activations of layers as functions of the kernels.
#pragma once

#include "core/io/files/policy_file.h"
#include "learn/network/kernels/kernel_table.h"

namespace skybody::learn {

inline Epilogue epilogue_of(Activation activation) {
  switch (activation) {
    case Activation::kTanh:
      return Epilogue::kTanh;
    case Activation::kRelu:
      return Epilogue::kRelu;
    case Activation::kElu:
      return Epilogue::kElu;
    case Activation::kNone:
      break;
  }
  return Epilogue::kNone;
}

/// The derivative, as a function of the output.
inline Epilogue slope_of(Activation activation) {
  switch (activation) {
    case Activation::kTanh:
      return Epilogue::kTanhSlope;
    case Activation::kRelu:
      return Epilogue::kReluSlope;
    case Activation::kElu:
      return Epilogue::kEluSlope;
    case Activation::kNone:
      break;
  }
  return Epilogue::kNone;
}

}  // namespace skybody::learn
