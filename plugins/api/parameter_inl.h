// Definitions for parameter.h.
#pragma once

#include "plugins/api/parameter.h"
#include "plugins/api/plugin.h"

namespace skybody {

inline Parameter::Parameter(Plugin* owner, const char* name, const char* unit, const char* doc,
                            std::uint32_t type)
    : name_(name), unit_(unit), doc_(doc), type_(type) {
  owner->parameters_.push_back(this);
}

inline SkybodyParameter Parameter::declaration() const {
  SkybodyParameter c{};
  c.name = name_;
  c.unit = unit_;
  c.doc = doc_;
  c.type = type_;
  c.min_count = min_count_;
  c.max_count = max_count_;
  c.required = required_ ? 1 : 0;
  c.randomizable = !randomizable_ ? 0 : when_given_ ? 2 : 1;
  c.is_file = is_file_ ? 1 : 0;
  c.min = min_;
  c.max = max_;
  c.default_numbers = default_numbers_.data();
  c.default_texts = default_texts_.data();
  c.default_count = static_cast<std::uint32_t>(type_ == SKYBODY_TEXT ? default_texts_.size()
                                                                     : default_numbers_.size());
  c.choices = choices_.data();
  c.choice_count = static_cast<std::uint32_t>(choices_.size());
  return c;
}

inline void Parameter::bind(const SkybodyValue& value) {
  env_param_ = value.env_param;
  is_given_ = value.is_given != 0;
  if (type_ == SKYBODY_TEXT) {
    texts_.assign(value.texts, value.texts + value.count);
  } else {
    numbers_.assign(value.numbers, value.numbers + value.count);
  }
}

inline RealParameter::RealParameter(Plugin* owner, const RealSpec& spec)
    : Parameter(owner, spec.name, spec.unit, spec.doc, SKYBODY_REAL) {
  min_ = spec.min;
  max_ = spec.max;
  required_ = spec.required;
  randomizable_ = spec.randomizable;
  when_given_ = spec.when_given;
  default_numbers_ = {spec.value};
}

inline RealsParameter::RealsParameter(Plugin* owner, const RealsSpec& spec)
    : Parameter(owner, spec.name, spec.unit, spec.doc, SKYBODY_REAL) {
  min_ = spec.min;
  max_ = spec.max;
  required_ = spec.required;
  randomizable_ = spec.randomizable;
  when_given_ = spec.when_given;
  min_count_ = spec.count < 0 ? 0 : spec.count;
  max_count_ = spec.count;
  default_numbers_ = spec.values;
}

inline IntegerParameter::IntegerParameter(Plugin* owner, const IntegerSpec& spec)
    : Parameter(owner, spec.name, spec.unit, spec.doc, SKYBODY_INTEGER) {
  min_ = static_cast<double>(spec.min);
  max_ = static_cast<double>(spec.max);
  required_ = spec.required;
  default_numbers_ = {static_cast<double>(spec.value)};
}

inline BooleanParameter::BooleanParameter(Plugin* owner, const BooleanSpec& spec)
    : Parameter(owner, spec.name, "", spec.doc, SKYBODY_BOOLEAN) {
  min_ = 0.0;
  max_ = 1.0;
  default_numbers_ = {spec.value ? 1.0 : 0.0};
}

inline TextParameter::TextParameter(Plugin* owner, const TextSpec& spec)
    : Parameter(owner, spec.name, "", spec.doc, SKYBODY_TEXT) {
  required_ = spec.required;
  is_file_ = spec.is_file;
  choices_ = spec.choices;
  default_texts_ = {spec.value};
}

inline TextsParameter::TextsParameter(Plugin* owner, const TextsSpec& spec)
    : Parameter(owner, spec.name, "", spec.doc, SKYBODY_TEXT) {
  required_ = spec.required;
  is_file_ = spec.is_file;
  min_count_ = 0;
  max_count_ = -1;
  default_texts_ = spec.values;
}

}  // namespace skybody
