#include "core/plugin_host/descriptor.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <set>
#include <string_view>

#include "core/base/plugin_kind.h"
#include "core/base/simd/isa.h"
#include "core/base/system/printable.h"

namespace skybody {
namespace {

/// Upper bounds of the copied counts: far beyond any plugin. They stop damaged numbers from
/// exhausting memory.
constexpr std::uint32_t kMostParameters = 1000, kMostEntries = 10'000;

/// The shortest decimal text that reads back as the same double.
std::string number(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value);
  return {text, end.ptr};
}

std::string quoted(const char* text) { return "`" + std::string(text) + "`"; }

/// Printable UTF-8 in one line, may be empty.
bool is_line(const char* text) { return text != nullptr && printable(text) == text; }

bool is_text(const char* text) { return is_line(text) && *text != '\0'; }

/// Lower-case words joined by underscores, starting with a letter.
bool is_snake_case(const char* name) {
  if (!is_text(name) || *name < 'a' || *name > 'z') return false;
  return std::string_view(name).find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") ==
         std::string_view::npos;
}

std::string numbers_problem(const SkybodyParameter& p) {
  if (p.default_count > 0 && p.default_numbers == nullptr) return "its default is missing";
  if (!(p.min <= p.max)) return "its range " + number(p.min) + ".." + number(p.max) + " is empty";
  for (std::uint32_t i = 0; i < p.default_count && p.required == 0; ++i) {
    const double value = p.default_numbers[i];
    if (!(value >= p.min && value <= p.max)) {
      return "its default " + number(value) + " is outside its range " + number(p.min) + ".." +
             number(p.max);
    }
    if (p.type != SKYBODY_REAL && value != std::floor(value)) {
      return "its default " + number(value) + " is not a whole number";
    }
  }
  return {};
}

std::string texts_problem(const SkybodyParameter& p) {
  if (p.default_count > 0 && p.default_texts == nullptr) return "its default is missing";
  if (p.choice_count > 0 && p.choices == nullptr) return "its choices are missing";
  for (std::uint32_t i = 0; i < p.choice_count; ++i) {
    if (p.choices[i] == nullptr) return "a choice is missing";
  }
  for (std::uint32_t i = 0; i < p.default_count && p.required == 0; ++i) {
    const char* value = p.default_texts[i];
    if (value == nullptr) return "its default is missing";
    const bool allowed = p.choice_count == 0 ||
                         std::any_of(p.choices, p.choices + p.choice_count, [value](const char* c) {
                           return std::string_view(c) == value;
                         });
    if (!allowed) return "its default " + quoted(value) + " is none of its choices";
  }
  return {};
}

std::string parameter_problem(const SkybodyParameter& p) {
  if (!is_line(p.unit) || !is_line(p.doc)) return "its unit or doc is missing or no line of text";
  if (p.type > SKYBODY_TEXT) return "its type " + std::to_string(p.type) + " is unknown";
  if (p.default_count > kMostEntries || p.choice_count > kMostEntries) {
    return "it has " + std::to_string(std::max(p.default_count, p.choice_count)) +
           " defaults or choices; allowed: at most " + std::to_string(kMostEntries);
  }
  const int most = p.max_count;
  if (p.min_count < 0 || most < -1 || (most >= 0 && most < p.min_count)) {
    return "its number of entries " + std::to_string(p.min_count) + ".." + std::to_string(most) +
           " is impossible";
  }
  const int count = static_cast<int>(p.default_count);
  if (p.required == 0 && (count < p.min_count || (most >= 0 && count > most))) {
    return "its default has " + std::to_string(count) + " entries, allowed are " +
           std::to_string(p.min_count) + (most == p.min_count ? "" : ".." + std::to_string(most));
  }
  if (p.randomizable != 0 && p.type != SKYBODY_REAL) return "only reals can be randomizable";
  if (p.is_file != 0 && p.type != SKYBODY_TEXT) return "only texts can name files";
  return p.type == SKYBODY_TEXT ? texts_problem(p) : numbers_problem(p);
}

bool has_step_function(const SkybodyKernels& kernels, std::uint32_t kind) {
  switch (kind) {
#define SKYBODY_ROW(symbol, type, word, folder, function) \
  case SKYBODY_##symbol:                                  \
    return kernels.function != nullptr;
    SKYBODY_PLUGIN_KINDS(SKYBODY_ROW)
#undef SKYBODY_ROW
    default:
      return false;
  }
}

std::string no_step_function(const SkybodyPlugin& plugin) {
  return "has no " + std::string(kPluginKinds[plugin.kind].function) + " function";
}

std::string kernels_problem(const SkybodyPlugin& plugin) {
  const SkybodyKernels& first = plugin.kernels[SKYBODY_NUMBER_REAL][0];
  for (int i = 0; i < kIsaCount; ++i) {
    const std::string isa = name(kIsas[i]);
    const SkybodyKernels& k = plugin.kernels[SKYBODY_NUMBER_REAL][i];
    if (!has_step_function(k, plugin.kind)) return no_step_function(plugin) + " for " + isa;
    if ((k.reset == nullptr) != (first.reset == nullptr) ||
        (k.process == nullptr) != (first.process == nullptr) ||
        (k.randomize == nullptr) != (first.randomize == nullptr) ||
        (k.goal == nullptr) != (first.goal == nullptr) ||
        (k.goal_motion == nullptr) != (first.goal_motion == nullptr)) {
      return "has other functions for " + isa + " than for " + name(kIsas[0]);
    }
  }
  return {};
}

bool has_any_function(const SkybodyKernels& k) {
  return k.reset != nullptr || k.control != nullptr || k.sense != nullptr ||
         k.randomize != nullptr || k.process != nullptr || k.apply != nullptr ||
         k.evaluate != nullptr || k.goal != nullptr || k.goal_motion != nullptr;
}

/// Functions on dual numbers: none, or for every instruction set the same ones as on real numbers.
std::string dual_kernels_problem(const SkybodyPlugin& plugin) {
  const auto& duals = plugin.kernels[SKYBODY_NUMBER_DUAL];
  if (std::none_of(std::begin(duals), std::end(duals), has_any_function)) return {};
  const SkybodyKernels& real = plugin.kernels[SKYBODY_NUMBER_REAL][0];
  for (int i = 0; i < kIsaCount; ++i) {
    const SkybodyKernels& k = duals[i];
    const std::string what = " on dual numbers for " + std::string(name(kIsas[i]));
    if (k.sense != nullptr || k.randomize != nullptr || k.goal != nullptr ||
        k.goal_motion != nullptr) {
      return "has a sense, randomize or goal function" + what + ", which nobody calls";
    }
    if (!has_step_function(k, plugin.kind)) return no_step_function(plugin) + what;
    if ((k.reset == nullptr) != (real.reset == nullptr) ||
        (k.process == nullptr) != (real.process == nullptr)) {
      return "has other functions" + what + " than on real numbers";
    }
  }
  return {};
}

/// @param names  of the parameters before this one; this one's name is added
std::string declaration_problem(const SkybodyParameter& p, std::set<std::string_view>& names) {
  if (!is_snake_case(p.name)) {
    return "has a badly named parameter " + quoted(p.name == nullptr ? "" : p.name) +
           ": lower-case letters, digits and underscores, a letter first";
  }
  const std::string declares = "declares parameter " + quoted(p.name);
  if (!names.insert(p.name).second) return declares + " twice";
  const std::string problem = parameter_problem(p);
  return problem.empty() ? problem : declares + ": " + problem;
}

}  // namespace

std::string descriptor_problem(const SkybodyPlugin& plugin) {
  if (!is_text(plugin.name)) return "has no name";
  const std::string who = "plugin " + quoted(plugin.name) + " ";
  if (!is_snake_case(plugin.name)) {
    return who + "has a bad name: lower-case letters, digits and underscores, a letter first";
  }
  if (plugin.kind >= SKYBODY_KIND_COUNT) {
    return who + "is of unknown kind " + std::to_string(plugin.kind);
  }
  if (!is_text(plugin.version)) return who + "has no version in one line of text";
  if (!is_text(plugin.doc)) return who + "has no line of documentation";
  if (plugin.create == nullptr || plugin.destroy == nullptr) {
    return who + "has no function to make or destroy an instance";
  }
  for (const std::string& problem : {kernels_problem(plugin), dual_kernels_problem(plugin)}) {
    if (!problem.empty()) return who + problem;
  }
  if (plugin.parameter_count > 0 && plugin.parameters == nullptr) {
    return who + "has lost its parameters";
  }
  if (plugin.parameter_count > kMostParameters) {
    return who + "declares " + std::to_string(plugin.parameter_count) +
           " parameters; allowed: at most " + std::to_string(kMostParameters);
  }
  std::set<std::string_view> names;
  for (std::uint32_t i = 0; i < plugin.parameter_count; ++i) {
    const std::string problem = declaration_problem(plugin.parameters[i], names);
    if (!problem.empty()) return who + problem;
  }
  return {};
}

std::vector<ParameterSpec> parameter_specs(const SkybodyPlugin& plugin) {
  std::vector<ParameterSpec> specs;
  for (std::uint32_t i = 0; i < plugin.parameter_count; ++i) {
    const SkybodyParameter& p = plugin.parameters[i];
    ParameterSpec spec;
    spec.name = p.name;
    spec.unit = p.unit;
    spec.doc = p.doc;
    spec.type = p.type == SKYBODY_REAL      ? ParameterType::kReal
                : p.type == SKYBODY_INTEGER ? ParameterType::kInteger
                : p.type == SKYBODY_BOOLEAN ? ParameterType::kBoolean
                                            : ParameterType::kText;
    spec.min_count = p.min_count;
    spec.max_count = p.max_count;
    spec.required = p.required != 0;
    spec.randomizable = p.randomizable != 0;
    spec.when_given = p.randomizable == 2;
    spec.is_file = p.is_file != 0;
    spec.choices.assign(p.choices, p.choices + p.choice_count);
    if (p.type != SKYBODY_TEXT) {
      spec.min = p.min;
      spec.max = p.max;
    }
    if (!spec.required && p.type == SKYBODY_TEXT) {
      spec.default_texts.assign(p.default_texts, p.default_texts + p.default_count);
    } else if (!spec.required) {
      spec.default_numbers.assign(p.default_numbers, p.default_numbers + p.default_count);
    }
    specs.push_back(std::move(spec));
  }
  return specs;
}

}  // namespace skybody
