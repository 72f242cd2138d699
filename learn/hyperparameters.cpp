#include "learn/hyperparameters.h"

#include <string_view>

namespace skybody::learn {
namespace {

constexpr std::string_view P = "P", G = "G", B = "B";

constexpr HyperparameterRow kRows[] = {
#define SKYBODY_ROW(TYPE, NAME, DEFAULT, LEAST, LARGEST, ALGORITHMS, MEANING) \
  {#NAME, #TYPE, LEAST, LARGEST, ALGORITHMS != G, ALGORITHMS != P, MEANING},
    SKYBODY_HYPERPARAMETERS(SKYBODY_ROW)
#undef SKYBODY_ROW
};

}  // namespace

std::span<const HyperparameterRow> hyperparameter_rows() { return kRows; }

}  // namespace skybody::learn
