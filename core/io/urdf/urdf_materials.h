// Checks the colours of a URDF. Internal to core/io's URDF reader.
//
// A <material> of the robot contains a <color> or a <texture>. A <material> of a visual contains
// either, or the name of a material of the robot or of another visual.
#pragma once

#include <tinyxml2.h>

#include <string>
#include <unordered_set>

#include "core/io/yaml/diagnostics.h"

namespace skybody {

class MaterialCheck {
 public:
  MaterialCheck(const std::string& file, Diagnostics& diagnostics)
      : file_(file), diagnostics_(diagnostics) {}

  /// Records a <material> of <robot>.
  void declare(const tinyxml2::XMLElement& material);

  /// Checks the material of a <visual> of `where`, if it has one.
  void check(const tinyxml2::XMLElement& visual, const std::string& where);

 private:
  void error(const tinyxml2::XMLElement& e, const std::string& message);
  std::string name_of(const tinyxml2::XMLElement& material);
  bool has_colour(const tinyxml2::XMLElement& material, const std::string& name);

  const std::string& file_;
  Diagnostics& diagnostics_;
  std::unordered_set<std::string> known_;
};

}  // namespace skybody
