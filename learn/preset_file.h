// The YAML file of presets: a section per learner, below it values as text, with their places.
#pragma once

#include <string>
#include <vector>

#include "core/model/scenario.h"

namespace skybody::learn {

/// A key with its value, in the form of `--set KEY=VALUE`.
struct PresetValue {
  std::string key;
  std::string text;  ///< of a list: its entries with commas between them
  SourceLocation mark;
};

/// The values of one learner.
struct PresetSection {
  std::string learner;
  SourceLocation mark;
  std::vector<PresetValue> values;  ///< in the order of the file
};

/// Reads a file of presets, and the files that its own `include` names.
/// @throws InputError with all mistakes, if the file is no YAML of this form
std::vector<PresetSection> read_preset_file(const std::string& file);

}  // namespace skybody::learn
