// Declarations of parameters: name, unit, default, range and one line of documentation. Each kind
// has a function that writes them as a row.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/math/math_basic.h"

namespace skybody {

/// One number. `value` is the default; if there is no default, set `required`.
struct RealSpec {
  const char* name;           ///< key in scenarios: a-z, 0-9 and _, starting with a letter
  const char* unit = "";      ///< such as "N m"; "" for a pure number
  double value = 0.0;         ///< the default, within the range
  double min = -kInfinity;    ///< inclusive
  double max = kInfinity;     ///< inclusive
  const char* doc = "";       ///< one line, for tables and the schema
  bool randomizable = false;  ///< one value per environment; randomizers may refer to it by path
  bool when_given = false;    ///< randomizable only where the scenario sets it; costs no state else
  bool required = false;      ///< the scenario must set it; the default is ignored
};

/// A vector of numbers. `count` -1: any length.
struct RealsSpec {
  const char* name;                 ///< key in scenarios
  const char* unit = "";            ///< unit of every value
  std::vector<double> values = {};  ///< the default, `count` of them
  int count = 3;                    ///< -1: any number
  double min = -kInfinity;          ///< of every value, inclusive
  double max = kInfinity;           ///< of every value, inclusive
  const char* doc = "";             ///< one line
  bool randomizable = false;        ///< every environment has its own values
  bool when_given = false;          ///< randomizable only where the scenario sets it
  bool required = false;            ///< the scenario must set it
};

/// A whole number.
struct IntegerSpec {
  const char* name;                             ///< key in scenarios
  const char* unit = "";                        ///< "" for a pure number
  std::int64_t value = 0;                       ///< the default
  std::int64_t min = -(std::int64_t{1} << 53);  ///< inclusive
  std::int64_t max = std::int64_t{1} << 53;     ///< inclusive
  const char* doc = "";                         ///< one line
  bool required = false;                        ///< the scenario must set it
};

/// true or false.
struct BooleanSpec {
  const char* name;      ///< key in scenarios
  bool value = false;    ///< the default
  const char* doc = "";  ///< one line
};

/// A word. Empty `choices`: any word.
struct TextSpec {
  const char* name;                       ///< key in scenarios
  const char* value = "";                 ///< the default
  std::vector<const char*> choices = {};  ///< allowed words
  const char* doc = "";                   ///< one line
  bool required = false;                  ///< the scenario must set it
  /// The word is a file name. A relative name starts at the folder of the YAML file that contains
  /// it, or at the working directory if it comes from the command line; value() is a path from the
  /// working directory. configure() must check that the file exists.
  bool is_file = false;
};

/// A list of words, of any length.
struct TextsSpec {
  const char* name;                      ///< key in scenarios
  std::vector<const char*> values = {};  ///< the default
  const char* doc = "";                  ///< one line
  bool required = false;                 ///< the scenario must set it
  bool is_file = false;                  ///< the words are file names, as in TextSpec
};

/// Allowed values of a number, bounds included.
struct ValueRange {
  double least = -kInfinity;    ///< the smallest value
  double greatest = kInfinity;  ///< the largest value
};
/// All numbers.
inline constexpr ValueRange kAny{};
/// Numbers from `least` on.
constexpr ValueRange at_least(double least) { return {least, kInfinity}; }
/// Numbers up to `greatest`.
constexpr ValueRange at_most(double greatest) { return {-kInfinity, greatest}; }
/// Numbers from `least` to `greatest`.
constexpr ValueRange between(double least, double greatest) { return {least, greatest}; }

/// A row for a RealParameter.
inline RealSpec real(const char* name, const char* unit, double value, const ValueRange& range,
                     const char* doc) {
  return {name, unit, value, range.least, range.greatest, doc};
}
/// A row for a RealsParameter with as many values as its default.
inline RealsSpec reals(const char* name, const char* unit, std::vector<double> values,
                       const ValueRange& range, const char* doc) {
  const int count = static_cast<int>(values.size());
  return {name, unit, std::move(values), count, range.least, range.greatest, doc};
}
/// A row for a RealsParameter with any number of values.
inline RealsSpec list(const char* name, const char* unit, std::vector<double> values,
                      const ValueRange& range, const char* doc) {
  return {name, unit, std::move(values), -1, range.least, range.greatest, doc};
}
/// A row for an IntegerParameter.
inline IntegerSpec integer(const char* name, const char* unit, std::int64_t value,
                           const ValueRange& range, const char* doc) {
  IntegerSpec spec{name, unit, value};
  if (range.least > -kInfinity) spec.min = static_cast<std::int64_t>(range.least);
  if (range.greatest < kInfinity) spec.max = static_cast<std::int64_t>(range.greatest);
  spec.doc = doc;
  return spec;
}
/// A row for a BooleanParameter.
inline BooleanSpec boolean(const char* name, bool value, const char* doc) {
  return {name, value, doc};
}
/// A row for a TextParameter with one of several words.
inline TextSpec choice(const char* name, const char* value, std::vector<const char*> choices,
                       const char* doc) {
  return {name, value, std::move(choices), doc};
}
/// A row for a TextParameter with any word.
inline TextSpec word(const char* name, const char* value, const char* doc) {
  return {name, value, {}, doc};
}
/// A row for a TextsParameter without a default.
inline TextsSpec words(const char* name, const char* doc) { return {name, {}, doc}; }
/// A row for a TextsParameter of file names without a default; values() are paths.
inline TextsSpec files(const char* name, const char* doc) { return {name, {}, doc, false, true}; }

/// The same parameter with a value of each environment.
template <class Spec>
Spec randomizable(Spec spec) {
  spec.randomizable = true;
  return spec;
}
/// The same parameter with a value of each environment if the scenario sets it; otherwise it costs
/// no state words.
template <class Spec>
Spec when_given(Spec spec) {
  spec.when_given = true;
  return randomizable(std::move(spec));
}
/// The same parameter without a default: the scenario must set it.
template <class Spec>
Spec required(Spec spec) {
  spec.required = true;
  return spec;
}

}  // namespace skybody
