// Checks XML texts before they are parsed, so that all readers interpret them equally and the
// parser's work and memory are bounded. Internal to core/io.
#pragma once

#include <tinyxml2.h>

#include <string>

#include "core/io/yaml/diagnostics.h"
#include "core/model/source_location.h"

namespace skybody {

/// Whether a bare `&` and unknown references are errors or stay unchanged (exporters of meshes
/// write them in names).
enum class XmlReferences { kChecked, kPassed };

/// Parses `text` into `document`. Returns false and an error in three cases:
/// - it is not well-formed
/// - it contains something that XML forbids and tinyxml2 accepts (a bare `&`, control characters)
/// - it has more tags or attributes than allowed: tinyxml2 needs about 100 bytes for each, and
///   compares each attribute of an element with all others
bool parse_xml(const std::string& text, const std::string& file, tinyxml2::XMLDocument& document,
               XmlReferences references, Diagnostics& diagnostics);

/// The location of an element's `<` in a text parsed by parse_xml().
SourceLocation xml_mark(const std::string& file, const tinyxml2::XMLElement& element);

}  // namespace skybody
