// Declared parameters: members of a plugin class with name, unit, default, range and one line of
// documentation. Validation, the docs table and the JSON schema are generated from them.
// parameter_specs.h has the rows that declare them. Definitions are in parameter_inl.h, which
// plugin.h includes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/plugin_abi/abi.h"
#include "plugins/api/env_view.h"
#include "plugins/api/parameter_specs.h"  // IWYU pragma: export

namespace skybody {

class Plugin;

/// Common base of all parameter members. Not copyable or movable: the plugin points to it.
class Parameter {
 public:
  Parameter(const Parameter&) = delete;
  Parameter& operator=(const Parameter&) = delete;

  /// For the library: the declaration in C form; points into this object.
  SkybodyParameter declaration() const;
  /// For the library: stores the validated value. Never throws: the host has checked type, count
  /// and range.
  void bind(const SkybodyValue& value);

  /// Whether the scenario sets the value; otherwise it is the default.
  bool is_given() const { return is_given_; }
  /// Index of the first value for EnvView::param() if it has one per environment, otherwise -1.
  int env_param() const { return env_param_; }
  /// Number of values per environment.
  int env_param_count() const { return env_param_ < 0 ? 0 : static_cast<int>(numbers_.size()); }

 protected:
  Parameter(Plugin* owner, const char* name, const char* unit, const char* doc, std::uint32_t type);

  const char *name_, *unit_, *doc_;
  std::uint32_t type_;
  int min_count_ = 1, max_count_ = 1;
  bool required_ = false, randomizable_ = false, when_given_ = false, is_file_ = false;
  double min_ = -kInfinity, max_ = kInfinity;
  std::vector<double> default_numbers_;
  std::vector<const char*> default_texts_, choices_;

  std::vector<double> numbers_;
  std::vector<std::string> texts_;
  int env_param_ = -1;
  bool is_given_ = false;
};

/// One number, declared as a member:
///   RealParameter gain{this, real("gain", "1/s", 2.0, at_least(0.0), "gain of the loop")};
class RealParameter : public Parameter {
 public:
  /// Registers with the plugin `owner`, which is `this`.
  RealParameter(Plugin* owner, const RealSpec& spec);
  /// The scenario's value, the same for all environments.
  double value() const { return numbers_[0]; }
  /// The value in each environment: the drawn value if randomizable, otherwise the scenario's.
  template <class Real>
  Real operator()(const EnvView<Real>& env) const {
    return env_param_ < 0 ? Real(numbers_[0]) : env.param(env_param_);
  }
};

/// Several numbers of one unit.
class RealsParameter : public Parameter {
 public:
  /// Registers with the plugin `owner`, which is `this`.
  RealsParameter(Plugin* owner, const RealsSpec& spec);
  /// Number of values; with `count` -1 in the spec the number that the scenario sets.
  int count() const { return static_cast<int>(numbers_.size()); }
  /// The scenario's value i, 0 <= i < count().
  double value(int i) const { return numbers_[static_cast<std::size_t>(i)]; }
  /// The scenario's first three values.
  Vec3<double> vec3() const { return {value(0), value(1), value(2)}; }
  /// Value i in each environment: the drawn value if randomizable, otherwise the scenario's.
  template <class Real>
  Real operator()(const EnvView<Real>& env, int i) const {
    return env_param_ < 0 ? Real(numbers_[static_cast<std::size_t>(i)]) : env.param(env_param_ + i);
  }
  /// The first three values in each environment.
  template <class Real>
  Vec3<Real> vec3(const EnvView<Real>& env) const {
    return {(*this)(env, 0), (*this)(env, 1), (*this)(env, 2)};
  }
};

/// A whole number.
class IntegerParameter : public Parameter {
 public:
  /// Registers with the plugin `owner`, which is `this`.
  IntegerParameter(Plugin* owner, const IntegerSpec& spec);
  /// The scenario's value.
  std::int64_t value() const { return static_cast<std::int64_t>(numbers_[0]); }
};

/// true or false.
class BooleanParameter : public Parameter {
 public:
  /// Registers with the plugin `owner`, which is `this`.
  BooleanParameter(Plugin* owner, const BooleanSpec& spec);
  /// The scenario's value.
  bool value() const { return numbers_[0] != 0.0; }
};

/// A word.
class TextParameter : public Parameter {
 public:
  /// Registers with the plugin `owner`, which is `this`.
  TextParameter(Plugin* owner, const TextSpec& spec);
  /// The scenario's word; one of the choices if there are any. For a file: its path.
  const std::string& value() const { return texts_[0]; }
};

/// A list of words.
class TextsParameter : public Parameter {
 public:
  /// Registers with the plugin `owner`, which is `this`.
  TextsParameter(Plugin* owner, const TextsSpec& spec);
  /// The scenario's words.
  const std::vector<std::string>& values() const { return texts_; }
};

}  // namespace skybody
