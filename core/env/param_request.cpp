#include "core/env/param_request.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <sstream>
#include <stdexcept>

#include "core/base/system/error.h"
#include "core/base/system/number_text.h"
#include "core/env/compiled_scenario.h"
#include "core/env/param_access.h"

namespace skybody {
namespace {

constexpr std::array<const char*, 3> kForms = {"value", "scale", "shift"};
constexpr std::array<const char*, 5> kKinds = {"constant", "uniform", "log_uniform", "normal",
                                               "choice"};

double exact_number(const std::string& text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const std::from_chars_result read = std::from_chars(text.data(), end, value);
  if (read.ec != std::errc() || read.ptr != end) throw Error("`" + text + "` is no number");
  return value;
}

template <std::size_t N>
int place_in(const std::array<const char*, N>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw Error("`" + name + "` is none of the known words");
  return static_cast<int>(found - names.begin());
}

/// The numbers that define a distribution.
std::vector<double> numbers_of(const Distribution& d) {
  switch (d.kind) {
    case DistributionKind::kConstant:
      return {d.low};
    case DistributionKind::kUniform:
    case DistributionKind::kLogUniform:
      return {d.low, d.high};
    case DistributionKind::kNormal:
      return {d.mean, d.deviation, d.low, d.high};
    case DistributionKind::kChoice:
      break;
  }
  std::vector<double> numbers = d.values;
  numbers.insert(numbers.end(), d.weights.begin(), d.weights.end());
  return numbers;
}

Distribution distribution_of(DistributionKind kind, const std::vector<double>& n) {
  const auto expect = [&](std::size_t count) {
    if (n.size() != count) throw Error("it has " + std::to_string(n.size()) + " numbers");
  };
  switch (kind) {
    case DistributionKind::kConstant:
      expect(1);
      return make_constant(n[0]);
    case DistributionKind::kUniform:
      expect(2);
      return make_uniform(n[0], n[1]);
    case DistributionKind::kLogUniform:
      expect(2);
      return make_log_uniform(n[0], n[1]);
    case DistributionKind::kNormal:
      expect(4);
      return make_normal(n[0], n[1], n[2], n[3]);
    case DistributionKind::kChoice:
      break;
  }
  const auto half = n.begin() + static_cast<std::ptrdiff_t>(n.size() / 2);
  return make_choice({n.begin(), half}, {half, n.end()});
}

}  // namespace

std::string ParamChange::text() const {
  std::string line = path + " " + kForms[static_cast<std::size_t>(form)] +
                     (is_shared ? " shared " : " each ") +
                     kKinds[static_cast<std::size_t>(distribution.kind)];
  for (const double number : numbers_of(distribution)) line += " " + exact_text(number);
  return line;
}

ParamChange read_param_change(const std::string& text) {
  std::istringstream in(text);
  std::string form, shared, kind, word;
  ParamChange change;
  in >> change.path >> form >> shared >> kind;
  std::vector<double> numbers;
  try {
    while (in >> word) numbers.push_back(exact_number(word));
    change.form = static_cast<ChangeForm>(place_in(kForms, form));
    change.is_shared = shared == "shared";
    change.distribution =
        distribution_of(static_cast<DistributionKind>(place_in(kKinds, kind)), numbers);
  } catch (const std::runtime_error& error) {
    throw Error("the change of `" + change.path + "` cannot be: " + error.what());
  }
  return change;
}

std::vector<ParamChange> read_param_changes(const std::vector<std::string>& lines) {
  std::vector<ParamChange> changes;
  for (const std::string& line : lines) changes.push_back(read_param_change(line));
  return changes;
}

ParamRequest::ParamRequest(const CompiledScenario& compiled, std::span<const ParamChange> changes,
                           bool redraws)
    : changes_(changes.begin(), changes.end()), redraws_(redraws) {
  const std::vector<EnvParam>& params = compiled.layout().param_info;
  for (std::size_t c = 0; c < changes_.size(); ++c) {
    bool is_first = true;
    for (const int k : find_params(compiled.scenario(), compiled.layout(), changes_[c].path)) {
      add(params[static_cast<std::size_t>(k)], k, c, is_first);
      is_first = false;
    }
  }
  std::vector<int> written;
  for (const Target& t : targets_) written.push_back(t.param);
  starts_ = compiled.model().starts.places_of(written);
}

void ParamRequest::add(const EnvParam& info, int param, std::size_t change, bool is_first) {
  for (const Target& t : targets_) {
    if (t.param != param) continue;
    throw Error("`" + changes_[change].path + "` names " + info.path +
                " a second time: name each value once");
  }
  const ParamChange& setpoint = changes_[change];
  const double factor = setpoint.form == ChangeForm::kScale ? info.nominal : 1.0;
  const double offset = setpoint.form == ChangeForm::kShift ? info.nominal : 0.0;
  const double a = setpoint.distribution.low * factor + offset;
  const double b = setpoint.distribution.high * factor + offset;
  if (!(std::min(a, b) >= info.min && std::max(a, b) <= info.max)) {
    throw Error(info.path + " would be in [" + exact_text(std::min(a, b)) + ", " +
                exact_text(std::max(a, b)) + "]" + (info.unit.empty() ? "" : " " + info.unit) +
                ": allowed is [" + exact_text(info.min) + ", " + exact_text(info.max) +
                "]; ask for less");
  }
  targets_.push_back({param, change, factor, offset, is_first || !setpoint.is_shared});
}

}  // namespace skybody
