// Texts about declarations, for messages and documentation.
#include <cmath>

#include "core/io/files/text.h"
#include "core/io/yaml/parameter_reader.h"

namespace skybody {
namespace {

std::string with_unit(const std::string& text, const std::string& unit) {
  return unit.empty() ? text : text + ' ' + unit;
}

/// " from 0 to 1 s", " of at least 0 s", or only the unit.
std::string range_text(const ParameterSpec& spec) {
  const bool lower = std::isfinite(spec.min);
  const bool upper = std::isfinite(spec.max);
  const std::string low = format_number(spec.min);
  const std::string high = with_unit(format_number(spec.max), spec.unit);
  if (lower && upper) {
    return spec.min_exclusive ? " above " + low + ", up to " + high
                              : " from " + low + " to " + high;
  }
  if (lower) return (spec.min_exclusive ? " above " : " of at least ") + with_unit(low, spec.unit);
  if (upper) return " of at most " + high;
  return spec.unit.empty() ? "" : " [" + spec.unit + "]";
}

std::string count_text(const ParameterSpec& spec) {
  if (spec.min_count == spec.max_count) return std::to_string(spec.min_count) + ' ';
  if (spec.max_count < 0) {
    return spec.min_count > 0 ? "at least " + std::to_string(spec.min_count) + ' ' : "";
  }
  return std::to_string(spec.min_count) + " to " + std::to_string(spec.max_count) + ' ';
}

std::string noun(const ParameterSpec& spec) {
  if (spec.type == ParameterType::kReal) return "number";
  if (spec.type == ParameterType::kInteger) return "integer";
  return spec.type == ParameterType::kBoolean ? "boolean" : "text";
}

}  // namespace

std::string describe_allowed(const ParameterSpec& spec) {
  if (!spec.is_scalar()) {
    std::string text = "a list of " + count_text(spec) + noun(spec);
    if (spec.max_count != 1) text += 's';
    if (!spec.choices.empty()) return text + " out of " + join(spec.choices);
    return text + range_text(spec);
  }
  switch (spec.type) {
    case ParameterType::kReal:
      return "a number" + range_text(spec);
    case ParameterType::kInteger:
      return "an integer" + range_text(spec);
    case ParameterType::kBoolean:
      return "true or false";
    case ParameterType::kText:
      break;
  }
  if (spec.is_file) return "the name of a file";
  return spec.choices.empty() ? "a text" : join(spec.choices);
}

std::string default_text(const ParameterSpec& spec) {
  if (spec.required) return "required";
  std::vector<std::string> words = spec.default_texts;
  for (double value : spec.default_numbers) {
    const bool boolean = spec.type == ParameterType::kBoolean;
    words.push_back(boolean ? (value != 0.0 ? "true" : "false") : format_number(value));
  }
  if (words.empty() || (words.size() == 1 && words[0].empty())) return "-";
  return spec.is_scalar() ? words[0] : '[' + join(words) + ']';
}

std::string parameter_table(const std::vector<ParameterSpec>& specs) {
  std::string table =
      "| name | allowed | default | meaning |\n"
      "|---|---|---|---|\n";
  for (const ParameterSpec& spec : specs) {
    const std::string note = spec.randomizable ? " (randomizable)" : "";
    table += "| `" + spec.name + "` | " + describe_allowed(spec) + " | " + default_text(spec) +
             " | " + spec.doc + note + " |\n";
  }
  return table;
}

}  // namespace skybody
