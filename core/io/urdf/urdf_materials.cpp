#include "core/io/urdf/urdf_materials.h"

#include <algorithm>

#include "core/io/urdf/urdf_xml.h"
#include "core/io/urdf/xml_text.h"

namespace skybody {

void MaterialCheck::error(const tinyxml2::XMLElement& e, const std::string& message) {
  diagnostics_.error(xml_mark(file_, e), message);
}

std::string MaterialCheck::name_of(const tinyxml2::XMLElement& material) {
  const char* name = material.Attribute("name");
  if (name == nullptr) error(material, "<material> has no name");
  return name == nullptr ? "" : name;
}

/// Whether it defines its own colour; an error if the colour is invalid.
bool MaterialCheck::has_colour(const tinyxml2::XMLElement& material, const std::string& name) {
  const tinyxml2::XMLElement* color = material.FirstChildElement("color");
  if (color == nullptr) return material.FirstChildElement("texture") != nullptr;
  const auto rgba = xml_numbers(*color, "rgba", 4);
  const auto outside = [](double value) { return !(value >= 0.0 && value <= 1.0); };
  if (!rgba || std::any_of(rgba->begin(), rgba->end(), outside)) {
    error(*color, "`rgba` of <color> in the material `" + name + "` must be 4 numbers from 0 to 1");
  }
  return true;
}

void MaterialCheck::declare(const tinyxml2::XMLElement& material) {
  const std::string name = name_of(material);
  if (name.empty()) return;
  if (!has_colour(material, name)) {
    error(material, "the material `" + name + "` has neither <color> nor <texture>");
  } else if (!known_.insert(name).second) {
    error(material, "a second material called `" + name + "`; names must differ");
  }
}

void MaterialCheck::check(const tinyxml2::XMLElement& visual, const std::string& where) {
  const tinyxml2::XMLElement* material = visual.FirstChildElement("material");
  if (material == nullptr) return;
  const std::string name = name_of(*material);
  if (has_colour(*material, name)) {
    known_.insert(name);
  } else if (!name.empty() && known_.count(name) == 0) {
    error(*material, "the material `" + name + "` of " + where +
                         " has no <color> and is not declared in <robot>; do one of both");
  }
}

}  // namespace skybody
