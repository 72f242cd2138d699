#include "core/io/urdf/urdf_xml.h"

#include <cmath>

#include "core/io/files/text.h"
#include "core/io/urdf/xml_text.h"

namespace skybody {
namespace {

using tinyxml2::XMLElement;

}  // namespace

std::optional<std::vector<double>> xml_numbers(const XMLElement& element, const char* attribute,
                                               int count) {
  const char* text = element.Attribute(attribute);
  if (text == nullptr) return std::nullopt;
  std::vector<double> values;
  for (const std::string& word : split_words(text)) {
    const std::optional<double> value = parse_number(word);
    if (!value || !std::isfinite(*value)) return std::nullopt;
    values.push_back(*value);
  }
  if (static_cast<int>(values.size()) != count) return std::nullopt;
  return values;
}

Pose xml_origin(const XMLElement& element) {
  Pose pose;
  const XMLElement* origin = element.FirstChildElement("origin");
  if (origin == nullptr) return pose;
  if (const auto xyz = xml_numbers(*origin, "xyz", 3)) {
    pose.position = {(*xyz)[0], (*xyz)[1], (*xyz)[2]};
  }
  if (const auto rpy = xml_numbers(*origin, "rpy", 3)) {
    pose.rotation = from_rpy((*rpy)[0], (*rpy)[1], (*rpy)[2]);
  }
  return pose;
}

bool check_urdf_xml(const std::string& text, const std::string& file, UrdfXml& xml,
                    Diagnostics& diagnostics) {
  const int errors_before = diagnostics.error_count();
  if (!parse_xml(text, file, xml.document, XmlReferences::kChecked, diagnostics)) return false;
  if (xml.document.RootElement() == nullptr) {
    diagnostics.error({file, 0, 0}, "the file has no XML element; a URDF is a <robot>");
    return false;
  }
  check_urdf_elements(file, xml, diagnostics);
  if (diagnostics.error_count() > errors_before) return false;
  return check_urdf_tree(xml, diagnostics);
}

}  // namespace skybody
