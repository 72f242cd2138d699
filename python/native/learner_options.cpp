#include "python/native/learner_options.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <typeinfo>
#include <vector>

#include "core/base/system/error.h"
#include "core/base/system/suggestion.h"
#include "learn/hyperparameter_text.h"

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
  to = learn::hidden_activation(nb::cast<std::string>(value));
}

/// @throws ValueError for another type or word, or a number out of range
template <class T>
void read_named(const char* name, nb::handle value, T& to, double least, double largest) {
  try {
    read(value, to);
  } catch (const Error& error) {
    throw nb::value_error(error.what());
  } catch (const std::bad_cast&) {
    char text[160];
    std::snprintf(text, sizeof(text), "hyper-parameter %s = %.60s: allowed is %g to %g", name,
                  nb::str(value).c_str(), least, largest);
    throw nb::value_error(text);
  }
}

nb::object shown(double value) { return nb::float_(value); }
nb::object shown(int value) { return nb::int_(value); }
nb::object shown(bool value) { return nb::bool_(value); }
nb::object shown(const Sizes& value) { return nb::tuple(nb::cast(value)); }
nb::object shown(Activation value) {
  return nb::str(std::string(kActivationNames[static_cast<std::size_t>(value)]).c_str());
}

}  // namespace

learn::Algorithm algorithm_of(const std::string& name) {
  std::vector<std::string> names;
  for (const char* known : learn::kAlgorithmNames) {
    if (name == known) return static_cast<learn::Algorithm>(names.size());
    names.emplace_back(known);
  }
  throw nb::value_error(("no learner `" + name + "`: " + join(names)).c_str());
}

learn::Hyperparameters hyperparameters_of(const nb::dict& values, learn::Algorithm algorithm) {
  const std::vector<std::string> names = learn::hyperparameter_names(algorithm);
  learn::Hyperparameters hyper;
  for (const auto [key, value] : values) {
    const auto name = nb::cast<std::string>(key);
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      throw nb::value_error(
          ("no hyper-parameter `" + name + "`" + suggestion(name, names)).c_str());
    }
#define SKYBODY_ROW(TYPE, NAME, DEFAULT, LEAST, LARGEST, ALGORITHMS, MEANING) \
  if (name == #NAME) read_named(#NAME, value, hyper.NAME, LEAST, LARGEST);
    SKYBODY_HYPERPARAMETERS(SKYBODY_ROW)
#undef SKYBODY_ROW
  }
  try {
    learn::check(hyper, algorithm);
  } catch (const Error& error) {
    throw nb::value_error(error.what());
  }
  return hyper;
}

nb::dict dict_of(const learn::Hyperparameters& hyper, learn::Algorithm algorithm) {
  nb::dict values;
  const learn::HyperparameterRow* row = learn::hyperparameter_rows().data();
#define SKYBODY_ROW(TYPE, NAME, DEFAULT, LEAST, LARGEST, ALGORITHMS, MEANING) \
  if (learn::has(*row, algorithm)) values[#NAME] = shown(hyper.NAME);         \
  ++row;
  SKYBODY_HYPERPARAMETERS(SKYBODY_ROW)
#undef SKYBODY_ROW
  return values;
}

learn::LearnerOptions learner_options(const LoadedScenario& scenario, learn::Algorithm algorithm,
                                      const nb::dict& hyper, std::uint64_t seed,
                                      std::int64_t total_steps, int threads) {
  return {.compiled = scenario.shared(),
          .hyper = hyperparameters_of(hyper, algorithm),
          .seed = seed,
          .total_steps = total_steps,
          .threads = threads};
}

}  // namespace skybody::python
