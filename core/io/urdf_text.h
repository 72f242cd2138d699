// What a URDF's text must be before it is parsed: plain XML that every reader takes for the same.
// Internal to core/io's URDF reader.
#pragma once

#include <string>

#include "core/io/diagnostics.h"

namespace skybody {

/// Looks for what XML forbids and tinyxml2 passes (a bare `&`, control characters), and for tags
/// with so many attributes that tinyxml2, which compares each with all, would take seconds.
/// Returns whether there was none.
bool check_xml_text(const std::string& text, const std::string& file, Diagnostics& diagnostics);

}  // namespace skybody
