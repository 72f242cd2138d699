// XML texts: checked before they are parsed, so that every reader takes them for the same and the
// parser's work and memory are bounded. Internal to core/io.
#pragma once

#include <tinyxml2.h>

#include <string>

#include "core/io/diagnostics.h"

namespace skybody {

/// Whether a bare `&` and unknown references are errors, or stay as they are (exporters of meshes
/// leave them in names).
enum class XmlReferences { kChecked, kPassed };

/// Parses `text` into `document`. An error, and false, where it is not well-formed, holds something
/// that XML forbids and tinyxml2 passes (a bare `&`, control characters), or has more tags and
/// attributes than are allowed: tinyxml2 takes about 100 bytes for each, and compares each
/// attribute of an element with all others.
bool parse_xml(const std::string& text, const std::string& file, tinyxml2::XMLDocument& document,
               XmlReferences references, Diagnostics& diagnostics);

}  // namespace skybody
