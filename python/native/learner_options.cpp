#include "python/native/learner_options.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstdio>
#include <iterator>
#include <string>
#include <string_view>
#include <type_traits>
#include <typeinfo>

#include "core/base/error.h"

namespace skybody::python {
namespace nb = nanobind;
namespace {

using learn::Sizes;

template <class T>
void read(nb::handle value, T& to) {
  to = nb::cast<T>(value);
}

void read(nb::handle value, double& to) { to = nb::cast<double>(nb::float_(value)); }

void read(nb::handle value, Sizes& to) {
  to.clear();
  for (const nb::handle size : nb::iter(value)) to.push_back(nb::cast<int>(size));
}

void read(nb::handle value, Activation& to) {
  const auto word = nb::cast<std::string>(value);
  for (std::size_t k = 1; k < std::size(kActivationNames); ++k) {
    if (word == kActivationNames[k]) {
      to = static_cast<Activation>(k);
      return;
    }
  }
  throw nb::value_error(
      ("hyper-parameter activation = " + word + ": allowed is tanh, relu or elu").c_str());
}

/// @throws ValueError beyond the list's range
template <class T>
void check(const char* name, const T& value, double least, double largest) {
  if constexpr (std::is_arithmetic_v<T>) {
    const auto number = static_cast<double>(value);
    if (number >= least && number <= largest) return;
    char text[160];
    std::snprintf(text, sizeof(text), "hyper-parameter %s = %g: allowed is %g to %g", name, number,
                  least, largest);
    throw nb::value_error(text);
  }
}

void check(const char* name, const Sizes& value, double least, double largest) {
  for (const int size : value) check(name, size, least, largest);
}

/// @throws ValueError for another type, a number that is too large for it, or one beyond the range
template <class T>
void read_checked(const char* name, nb::handle value, T& to, double least, double largest) {
  try {
    read(value, to);
  } catch (const std::bad_cast&) {
    char text[160];
    std::snprintf(text, sizeof(text), "hyper-parameter %s = %.60s: allowed is %g to %g", name,
                  nb::str(value).c_str(), least, largest);
    throw nb::value_error(text);
  }
  check(name, to, least, largest);
}

nb::object shown(double value) { return nb::float_(value); }
nb::object shown(int value) { return nb::int_(value); }
nb::object shown(bool value) { return nb::bool_(value); }
nb::object shown(const Sizes& value) { return nb::tuple(nb::cast(value)); }
nb::object shown(Activation value) {
  return nb::str(std::string(kActivationNames[static_cast<std::size_t>(value)]).c_str());
}

}  // namespace

learn::Hyperparameters hyperparameters_of(const nb::dict& values) {
  learn::Hyperparameters hyper;
  for (const auto [key, value] : values) {
    const auto name = nb::cast<std::string>(key);
    bool is_known = false;
#define SKYBODY_ROW(TYPE, NAME, DEFAULT, LEAST, LARGEST, ALGORITHMS, MEANING) \
  if (name == #NAME) {                                                        \
    is_known = true;                                                          \
    read_checked(#NAME, value, hyper.NAME, LEAST, LARGEST);                   \
  }
    SKYBODY_HYPERPARAMETERS(SKYBODY_ROW)
#undef SKYBODY_ROW
    if (!is_known) throw nb::value_error(("no hyper-parameter `" + name + "`").c_str());
  }
  return hyper;
}

nb::dict dict_of(const learn::Hyperparameters& hyper, const std::string& algorithm) {
  const bool is_gradient = algorithm == "gradient";
  if (!is_gradient && algorithm != "fast-ppo") {
    throw nb::value_error(("no learner `" + algorithm + "`: fast-ppo, gradient").c_str());
  }
  nb::dict values;
  const auto has = [&](const char* name) {
    for (const learn::HyperparameterRow& row : learn::hyperparameter_rows()) {
      if (std::string_view(row.name) == name) return is_gradient ? row.gradient : row.fast_ppo;
    }
    return false;
  };
#define SKYBODY_ROW(TYPE, NAME, DEFAULT, LEAST, LARGEST, ALGORITHMS, MEANING) \
  if (has(#NAME)) values[#NAME] = shown(hyper.NAME);
  SKYBODY_HYPERPARAMETERS(SKYBODY_ROW)
#undef SKYBODY_ROW
  return values;
}

learn::LearnerOptions learner_options(const LoadedScenario& scenario, const nb::dict& hyper,
                                      std::uint64_t seed, std::int64_t total_steps, int threads) {
  return {.compiled = scenario.shared(),
          .hyper = hyperparameters_of(hyper),
          .seed = seed,
          .total_steps = total_steps,
          .threads = threads};
}

}  // namespace skybody::python
