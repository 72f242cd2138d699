#include "core/io/urdf_materials.h"

#include <algorithm>

#include "core/io/ranges.h"
#include "core/io/urdf_xml.h"

namespace skybody {
namespace {

constexpr Rgba kTextured{0.0, 0.0, 0.0, 1.0};  // what readers of URDF paint where a texture is

}  // namespace

void UrdfMaterials::error(const tinyxml2::XMLElement& e, const std::string& message) {
  diagnostics_.error({file_, e.GetLineNum(), 0}, message);
}

std::string UrdfMaterials::name_of(const tinyxml2::XMLElement& material) {
  const char* name = material.Attribute("name");
  if (name == nullptr) error(material, "<material> has no name");
  return name == nullptr ? "" : name;
}

std::optional<Rgba> UrdfMaterials::read(const tinyxml2::XMLElement& material,
                                        const std::string& name) {
  const tinyxml2::XMLElement* color = material.FirstChildElement("color");
  if (color == nullptr) {
    if (material.FirstChildElement("texture") == nullptr) return std::nullopt;
    return kTextured;
  }
  const auto numbers = xml_numbers(*color, "rgba", 4);
  const auto far = [](double value) { return !kScaleRange.has(value); };
  if (!numbers || std::any_of(numbers->begin(), numbers->end(), far)) {
    error(*color, "`rgba` of <color> in the material `" + name + "` must be 4 numbers from 0 to 1");
    return kTextured;
  }
  Rgba rgba;
  for (std::size_t i = 0; i < 4; ++i) rgba[i] = static_cast<float>((*numbers)[i]);
  return rgba;
}

void UrdfMaterials::declare(const tinyxml2::XMLElement& material) {
  const std::string name = name_of(material);
  if (name.empty()) return;
  const std::optional<Rgba> rgba = read(material, name);
  if (!rgba) {
    error(material, "the material `" + name + "` has neither <color> nor <texture>");
  } else if (!known_.emplace(name, *rgba).second) {
    error(material, "a second material called `" + name + "`; names must differ");
  }
}

std::optional<Rgba> UrdfMaterials::of(const tinyxml2::XMLElement& visual,
                                      const std::string& where) {
  const tinyxml2::XMLElement* material = visual.FirstChildElement("material");
  if (material == nullptr) return std::nullopt;
  const std::string name = name_of(*material);
  const std::optional<Rgba> own = read(*material, name);
  if (name.empty()) return own;
  if (own) return known_.emplace(name, *own).first->second;
  const auto known = known_.find(name);
  if (known != known_.end()) return known->second;
  error(*material, "the material `" + name + "` of " + where +
                       " has no <color> and is not declared in <robot>; do one of both");
  return std::nullopt;
}

}  // namespace skybody
