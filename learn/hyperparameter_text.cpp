#include "learn/hyperparameter_text.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/system/error.h"
#include "core/io/files/text.h"

namespace skybody::learn {
namespace {

// Each overload parses the whole text; on failure it returns the expected form.

const char* read(std::string_view text, double& to) {
  const std::optional<double> value = parse_number(text);
  if (!value) return "a number";
  to = *value;
  return nullptr;
}

const char* read(std::string_view text, int& to) {
  const std::optional<double> value = parse_number(text);
  const bool is_whole = value && std::isfinite(*value) && std::floor(*value) == *value &&
                        std::abs(*value) <= std::numeric_limits<int>::max();
  if (!is_whole) return "a whole number";
  to = static_cast<int>(*value);
  return nullptr;
}

const char* read(std::string_view text, bool& to) {
  const bool is_true = text == "true" || text == "True";
  if (!is_true && text != "false" && text != "False") return "true or false";
  to = is_true;
  return nullptr;
}

/// Empty text: no layers.
const char* read(std::string_view text, Sizes& to) {
  Sizes sizes;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t end = rest.find(',');
    const std::size_t first = std::min(rest.find_first_not_of(' '), rest.size());
    int& size = sizes.emplace_back();
    if (read(rest.substr(first, std::min(end, rest.size()) - first), size) != nullptr) {
      return "sizes as 64,64";
    }
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  }
  to = sizes;
  return nullptr;
}

const char* read(std::string_view text, Activation& to) {
  to = hidden_activation(std::string(text));
  return nullptr;
}

}  // namespace

Activation hidden_activation(const std::string& word) {
  const std::optional<Activation> found = find_activation(word);
  if (found && *found != Activation::kNone) return *found;
  const std::vector<std::string> allowed(std::begin(kActivationNames) + 1,
                                         std::end(kActivationNames));
  throw Error("`activation` is `" + word + "`; allowed: " + join(allowed));
}

void set(Hyperparameters& hyper, Algorithm algorithm, const std::string& setting) {
  const std::size_t at = setting.find('=');
  if (at == std::string::npos) throw Error("`" + setting + "`: write NAME=VALUE");
  const std::string name = setting.substr(0, at), text = setting.substr(at + 1);
  const char* form = nullptr;
  const HyperparameterRow* row = hyperparameter_rows().data();
  bool is_there = false;
#define SKYBODY_ROW(TYPE, NAME, DEFAULT, LEAST, LARGEST, ALGORITHMS, MEANING) \
  if (name == #NAME && has(*row, algorithm)) {                                \
    is_there = true;                                                          \
    form = read(text, hyper.NAME);                                            \
  }                                                                           \
  ++row;
  SKYBODY_HYPERPARAMETERS(SKYBODY_ROW)
#undef SKYBODY_ROW
  if (!is_there) {
    throw Error("no hyper-parameter `" + name + "`" +
                suggestion(name, hyperparameter_names(algorithm)));
  }
  if (form != nullptr) throw Error("`" + setting + "`: `" + text + "` is not " + form);
}

}  // namespace skybody::learn
