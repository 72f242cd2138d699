#include "core/io/yaml/parameter_reader.h"

#include <algorithm>
#include <cmath>

#include "core/io/files/file.h"
#include "core/io/files/text.h"
#include "core/io/files/unit_hint.h"
#include "core/io/yaml/plausibility_limits.h"

namespace skybody {
namespace {

constexpr double kLargestInteger = 9007199254740992.0;  // 2^53: doubles skip integers above it

/// Reads the entries of one value.
class ValueReader {
 public:
  ValueReader(const ParameterSpec& spec, Broadcast broadcast, Diagnostics& diagnostics)
      : spec_(spec), broadcast_(broadcast), diagnostics_(diagnostics) {
    value_.name = spec.name;
    value_.type = spec.type;
  }

  std::optional<ParameterValue> read(const ConfigNode& node) {
    value_.mark = node.mark;
    if (spec_.is_scalar()) return take(node, spec_.name) ? done() : std::nullopt;
    if (node.is_scalar() && broadcasts()) {
      if (!take(node, spec_.name)) return std::nullopt;
      value_.numbers.assign(static_cast<std::size_t>(spec_.max_count), value_.numbers[0]);
      return done();
    }
    if (!node.is_sequence()) return refuse(node);
    const int count = static_cast<int>(node.items.size());
    if (count < spec_.min_count || (spec_.max_count >= 0 && count > spec_.max_count)) {
      diagnostics_.error(node.mark, "`" + spec_.name + "` has " + std::to_string(count) +
                                        (count == 1 ? " entry" : " entries") +
                                        "; allowed: " + describe_allowed(spec_));
      return std::nullopt;
    }
    bool good = true;
    for (int i = 0; i < count; ++i) {
      const std::string name = spec_.name + '[' + std::to_string(i) + ']';
      is_last_ = i + 1 == count;
      good = take(node.items[static_cast<std::size_t>(i)], name) && good;
    }
    return good ? done() : std::nullopt;
  }

 private:
  bool broadcasts() const {
    return broadcast_ == Broadcast::kYes && spec_.type != ParameterType::kText &&
           spec_.min_count == spec_.max_count && spec_.min_count > 1;
  }

  std::optional<ParameterValue> done() { return std::move(value_); }

  std::optional<ParameterValue> refuse(const ConfigNode& node) {
    complain(node, spec_.name, node.describe(), list_hint(node));
    return std::nullopt;
  }

  /// "; do you mean [1, 2, 3]?" for numbers without the brackets of a list, else "".
  static std::string list_hint(const ConfigNode& node) {
    std::string text = node.scalar;
    std::replace(text.begin(), text.end(), ',', ' ');
    std::vector<double> numbers;
    for (const std::string& word : split_words(text)) {
      const std::optional<double> number = parse_number(word);
      if (!number) return "";
      numbers.push_back(*number);
    }
    return numbers.size() < 2 ? "" : "; do you mean " + format_numbers(numbers) + "?";
  }

  /// @param hint  advice at the end of the message
  bool complain(const ConfigNode& node, const std::string& name, const std::string& what,
                const std::string& hint = "") {
    const bool in_list = name != spec_.name;
    ParameterSpec entry = spec_;
    if (in_list) entry.min_count = entry.max_count = 1;
    diagnostics_.error(
        node.mark, "`" + name + "` is " + what + "; allowed: " + describe_allowed(entry) + hint);
    return false;
  }

  bool take(const ConfigNode& node, const std::string& name) {
    if (!node.is_scalar()) return complain(node, name, node.describe());
    switch (spec_.type) {
      case ParameterType::kText:
        return take_text(node, name);
      case ParameterType::kBoolean:
        return take_boolean(node, name);
      default:
        return take_number(node, name);
    }
  }

  bool take_text(const ConfigNode& node, const std::string& name) {
    const std::vector<std::string>& choices = spec_.choices;
    const bool known = std::find(choices.begin(), choices.end(), node.scalar) != choices.end();
    if (!choices.empty() && !known) {
      diagnostics_.error(node.mark, "`" + name + "` is `" + node.scalar +
                                        "`; allowed: " + join(choices) + did_you_mean(node.scalar));
      return false;
    }
    value_.texts.push_back(spec_.is_file ? resolve_path(node.scalar, node.mark) : node.scalar);
    return true;
  }

  std::string did_you_mean(const std::string& word) const {
    const std::string found = closest(word, spec_.choices);
    return found.empty() ? "" : "; did you mean `" + found + "`?";
  }

  bool take_boolean(const ConfigNode& node, const std::string& name) {
    if (node.quoted || (node.scalar != "true" && node.scalar != "false")) {
      return complain(node, name, node.describe());
    }
    value_.numbers.push_back(node.scalar == "true" ? 1.0 : 0.0);
    return true;
  }

  bool take_number(const ConfigNode& node, const std::string& name) {
    const std::optional<double> number = node.quoted ? std::nullopt : parse_number(node.scalar);
    if (!number) return complain(node, name, node.describe(), unit_hint(node.scalar, spec_.unit));
    const bool integer = spec_.type == ParameterType::kInteger;
    const bool integral = std::isfinite(*number) && std::trunc(*number) == *number &&
                          std::fabs(*number) <= kLargestInteger;
    const bool below = *number < spec_.min || (spec_.min_exclusive && *number == spec_.min);
    if (!std::isfinite(*number) || (integer && !integral) || below || *number > spec_.max) {
      return complain(node, name, node.scalar);
    }
    if (is_angle()) {
      warn_if_implausible(PlausibilityLimit::kAngle, *number, "`" + name + "`", {}, node.mark,
                          diagnostics_);
    }
    value_.numbers.push_back(*number);
    return true;
  }

  /// Whether the current value is in rad: by its unit, or as the last of a list in "m, rad".
  bool is_angle() const {
    const std::string& unit = spec_.unit;
    const std::string ending = ", rad";
    return unit == "rad" || (is_last_ && unit.size() > ending.size() &&
                             unit.compare(unit.size() - ending.size(), ending.size(), ending) == 0);
  }

  const ParameterSpec& spec_;
  bool is_last_ = false;  ///< of a list
  Broadcast broadcast_;
  Diagnostics& diagnostics_;
  ParameterValue value_;
};

}  // namespace

ParameterValue default_value(const ParameterSpec& spec, const SourceLocation& mark) {
  ParameterValue value;
  value.name = spec.name;
  value.type = spec.type;
  value.numbers = spec.default_numbers;
  value.texts = spec.default_texts;
  value.is_given = false;
  value.mark = mark;
  return value;
}

std::optional<ParameterValue> read_value(const ConfigNode& node, const ParameterSpec& spec,
                                         Broadcast broadcast, Diagnostics& diagnostics) {
  return ValueReader(spec, broadcast, diagnostics).read(node);
}

std::vector<ParameterValue> read_parameters(const ConfigNode& map,
                                            const std::vector<ParameterSpec>& specs,
                                            Diagnostics& diagnostics) {
  std::vector<std::string> names;
  for (const ParameterSpec& spec : specs) names.push_back(spec.name);
  if (!map.is_map() && !map.is_null()) {
    diagnostics.error(map.mark, "`parameters` is " + map.describe() + "; allowed: a map");
  }
  for (const ConfigEntry& entry : map.entries) {
    if (std::find(names.begin(), names.end(), entry.key) != names.end()) continue;
    diagnostics.error(entry.key_mark, "unknown parameter `" + entry.key + "`" +
                                          suggestion(entry.key, names, "parameters"));
  }
  std::vector<ParameterValue> values;
  for (const ParameterSpec& spec : specs) {
    const ConfigNode* node = map.find(spec.name);
    std::optional<ParameterValue> value;
    if (node != nullptr) {
      value = read_value(*node, spec, Broadcast::kYes, diagnostics);
    } else if (spec.required) {
      diagnostics.error(map.mark, "the parameter `" + spec.name + "` is missing; it is " +
                                      describe_allowed(spec) + ": " + spec.doc);
    }
    values.push_back(value ? *value : default_value(spec, map.mark));
  }
  return values;
}

}  // namespace skybody
