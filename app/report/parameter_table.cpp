#include "app/report/parameter_table.h"

#include <cmath>
#include <sstream>

#include "app/report/text_table.h"
#include "core/io/files/text.h"

namespace skybody {
namespace {

/// The texts of one parameter.
struct Words {
  std::string name, type, unit, default_value, range, randomizable, doc;
};

std::string type_of(const ParameterSpec& spec) {
  const char* names[] = {"real", "integer", "boolean", "text"};
  const std::string type = names[static_cast<int>(spec.type)];
  if (spec.is_scalar()) return type;
  if (spec.min_count == spec.max_count) return type + "[" + std::to_string(spec.min_count) + "]";
  const std::string most = spec.max_count < 0 ? "" : std::to_string(spec.max_count);
  return type + "[" + std::to_string(spec.min_count) + ".." + most + "]";
}

std::string number_text(const ParameterSpec& spec, double value) {
  if (spec.type == ParameterType::kBoolean) return value != 0.0 ? "true" : "false";
  return format_number(value);
}

std::string default_of(const ParameterSpec& spec) {
  if (spec.required) return "required";
  std::vector<std::string> values = spec.default_texts;
  for (const double value : spec.default_numbers) values.push_back(number_text(spec, value));
  return spec.is_scalar() ? join(values) : "[" + join(values) + "]";
}

std::string range_of(const ParameterSpec& spec) {
  if (spec.type == ParameterType::kText) return join(spec.choices, " or ");
  if (spec.type == ParameterType::kBoolean) return "";
  const bool low = std::isfinite(spec.min), high = std::isfinite(spec.max);
  if (low && high && !spec.min_exclusive) {
    return format_number(spec.min) + ".." + format_number(spec.max);
  }
  std::string text;
  if (low) text = (spec.min_exclusive ? "> " : ">= ") + format_number(spec.min);
  if (high) text += (low ? ", " : "") + ("<= " + format_number(spec.max));
  return text;
}

Words words_of(const ParameterSpec& spec) {
  return {spec.name,        type_of(spec),  spec.unit,
          default_of(spec), range_of(spec), spec.randomizable ? "yes" : "",
          spec.doc};
}

/// Escapes a bar, which would end the cell.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '|') result += '\\';
    result += c;
  }
  return result;
}

}  // namespace

std::string parameter_lines(const std::vector<ParameterSpec>& parameters) {
  TextTable table({"parameter", "type", "unit", "default", "range", "randomizable", "meaning"});
  for (const ParameterSpec& spec : parameters) {
    const Words w = words_of(spec);
    table.add({w.name, w.type, w.unit, w.default_value, w.range, w.randomizable, w.doc});
  }
  std::istringstream lines(table.to_string());
  std::string text;
  for (std::string line; std::getline(lines, line);) text += "    " + line + "\n";
  return text;
}

std::string parameter_markdown(const std::vector<ParameterSpec>& parameters) {
  std::string text =
      "| Parameter | Type | Unit | Default | Range | Randomizable | Meaning |\n"
      "|---|---|---|---|---|---|---|\n";
  for (const ParameterSpec& spec : parameters) {
    const Words w = words_of(spec);
    text += "| `" + w.name + "` | " + w.type + " | " + escaped(w.unit) + " | " +
            escaped(w.default_value) + " | " + escaped(w.range) + " | " + w.randomizable + " | " +
            escaped(w.doc) + " |\n";
  }
  return text;
}

}  // namespace skybody
