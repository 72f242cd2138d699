// Colours of a URDF. Internal to core/io's URDF reader.
//
// A <material> of the robot or of a visual with a <color> or <texture> gives its name a colour; a
// visual's <material> without either names one that was given. The first one counts.
#pragma once

#include <tinyxml2.h>

#include <array>
#include <optional>
#include <string>
#include <unordered_map>

#include "core/io/diagnostics.h"

namespace skybody {

using Rgba = std::array<double, 4>;

class UrdfMaterials {
 public:
  UrdfMaterials(const std::string& file, Diagnostics& diagnostics)
      : file_(file), diagnostics_(diagnostics) {}

  /// Notes a <material> of <robot>.
  void declare(const tinyxml2::XMLElement& material);

  /// The colour of a <visual> of `where`, if it has a material.
  std::optional<Rgba> of(const tinyxml2::XMLElement& visual, const std::string& where);

 private:
  void error(const tinyxml2::XMLElement& e, const std::string& message);
  std::string name_of(const tinyxml2::XMLElement& material);
  std::optional<Rgba> read(const tinyxml2::XMLElement& material, const std::string& name);

  const std::string& file_;
  Diagnostics& diagnostics_;
  std::unordered_map<std::string, Rgba> known_;
};

}  // namespace skybody
