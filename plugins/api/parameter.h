// Declared parameters: members of a plugin class that carry name, unit, default, range and one line
// of documentation. Validation, the docs table and the JSON schema all come from here.
// Definitions are in parameter_inl.h, which plugin.h includes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/math_basic.h"
#include "plugins/api/abi.h"
#include "plugins/api/lanes.h"

namespace skybody {

/// One number. `value` is the default; without a default set `required`.
struct RealSpec {
  const char* name;
  const char* unit = "";
  double value = 0.0;
  double min = -kInfinity;  ///< inclusive
  double max = kInfinity;   ///< inclusive
  const char* doc = "";
  bool randomizable = false;  ///< one value per environment; randomizers may name it by path
  bool required = false;
};

/// A vector of numbers. `count` -1: any length.
struct RealsSpec {
  const char* name;
  const char* unit = "";
  std::vector<double> values = {};
  int count = 3;
  double min = -kInfinity;
  double max = kInfinity;
  const char* doc = "";
  bool randomizable = false;
  bool required = false;
};

struct IntegerSpec {
  const char* name;
  const char* unit = "";
  std::int64_t value = 0;
  std::int64_t min = -(std::int64_t{1} << 53);
  std::int64_t max = std::int64_t{1} << 53;
  const char* doc = "";
  bool required = false;
};

struct BooleanSpec {
  const char* name;
  bool value = false;
  const char* doc = "";
};

/// A word. `choices` empty: anything.
struct TextSpec {
  const char* name;
  const char* value = "";
  std::vector<const char*> choices = {};
  const char* doc = "";
  bool required = false;
};

/// A list of words, of any length.
struct TextsSpec {
  const char* name;
  std::vector<const char*> values = {};
  const char* doc = "";
  bool required = false;
};

class Plugin;

/// What all parameter members have in common. Neither copied nor moved: the plugin points to it.
class Parameter {
 public:
  Parameter(const Parameter&) = delete;
  Parameter& operator=(const Parameter&) = delete;

  /// The declaration in C form; points into this object.
  SkybodyParameter declaration() const;
  /// Takes the validated value. @throws nothing: the host has checked type, count and range.
  void bind(const SkybodyValue& value);

 protected:
  Parameter(Plugin* owner, const char* name, const char* unit, const char* doc, std::uint32_t type);

  const char *name_, *unit_, *doc_;
  std::uint32_t type_;
  int min_count_ = 1, max_count_ = 1;
  bool required_ = false, randomizable_ = false;
  double min_ = -kInfinity, max_ = kInfinity;
  std::vector<double> default_numbers_;
  std::vector<const char*> default_texts_, choices_;

  std::vector<double> numbers_;
  std::vector<std::string> texts_;
  int env_param_ = -1;
};

class RealParameter : public Parameter {
 public:
  RealParameter(Plugin* owner, const RealSpec& spec);
  /// The configured (nominal) value.
  double value() const { return numbers_[0]; }
  /// The value of each environment: drawn if it is randomizable, else the configured one.
  template <class Real>
  Real operator()(const Lanes<Real>& env) const {
    return env_param_ < 0 ? Real(numbers_[0]) : env.param(env_param_);
  }
};

class RealsParameter : public Parameter {
 public:
  RealsParameter(Plugin* owner, const RealsSpec& spec);
  int count() const { return static_cast<int>(numbers_.size()); }
  double value(int i) const { return numbers_[static_cast<std::size_t>(i)]; }
  Vec3<double> vec3() const { return {value(0), value(1), value(2)}; }
  template <class Real>
  Real operator()(const Lanes<Real>& env, int i) const {
    return env_param_ < 0 ? Real(numbers_[static_cast<std::size_t>(i)]) : env.param(env_param_ + i);
  }
  template <class Real>
  Vec3<Real> vec3(const Lanes<Real>& env) const {
    return {(*this)(env, 0), (*this)(env, 1), (*this)(env, 2)};
  }
};

class IntegerParameter : public Parameter {
 public:
  IntegerParameter(Plugin* owner, const IntegerSpec& spec);
  std::int64_t value() const { return static_cast<std::int64_t>(numbers_[0]); }
};

class BooleanParameter : public Parameter {
 public:
  BooleanParameter(Plugin* owner, const BooleanSpec& spec);
  bool value() const { return numbers_[0] != 0.0; }
};

class TextParameter : public Parameter {
 public:
  TextParameter(Plugin* owner, const TextSpec& spec);
  const std::string& value() const { return texts_[0]; }
};

class TextsParameter : public Parameter {
 public:
  TextsParameter(Plugin* owner, const TextsSpec& spec);
  const std::vector<std::string>& values() const { return texts_; }
};

}  // namespace skybody
