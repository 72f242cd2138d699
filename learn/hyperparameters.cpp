#include "learn/hyperparameters.h"

#include <cstdio>
#include <string_view>
#include <type_traits>

#include "core/base/error.h"

namespace skybody::learn {
namespace {

constexpr std::string_view P = "P", G = "G", B = "B";

constexpr HyperparameterRow kRows[] = {
#define SKYBODY_ROW(TYPE, NAME, DEFAULT, LEAST, LARGEST, ALGORITHMS, MEANING) \
  {#NAME, LEAST, LARGEST, ALGORITHMS != G, ALGORITHMS != P, MEANING},
    SKYBODY_HYPERPARAMETERS(SKYBODY_ROW)
#undef SKYBODY_ROW
};

template <class T>
void check_value(const HyperparameterRow& row, const T& value) {
  if constexpr (std::is_arithmetic_v<T>) {
    const auto number = static_cast<double>(value);
    if (number >= row.least && number <= row.largest) return;
    char text[160];
    std::snprintf(text, sizeof(text), "hyper-parameter %s = %g: allowed is %g to %g", row.name,
                  number, row.least, row.largest);
    throw Error(text);
  }
}

void check_value(const HyperparameterRow& row, const Sizes& sizes) {
  for (const int size : sizes) check_value(row, size);
}

}  // namespace

std::span<const HyperparameterRow> hyperparameter_rows() { return kRows; }

void check(const Hyperparameters& hyper, Algorithm algorithm) {
  const HyperparameterRow* row = kRows;
#define SKYBODY_ROW(TYPE, NAME, DEFAULT, LEAST, LARGEST, ALGORITHMS, MEANING) \
  if (has(*row, algorithm)) check_value(*row, hyper.NAME);                    \
  ++row;
  SKYBODY_HYPERPARAMETERS(SKYBODY_ROW)
#undef SKYBODY_ROW
}

}  // namespace skybody::learn
