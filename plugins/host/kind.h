// The four kinds of plugins, by name.
#pragma once

#include <optional>
#include <string_view>

#include "plugins/api/abi.h"

namespace skybody {

/// "controller", "sensor", "randomizer", "task"; "plugin" for SKYBODY_KIND_COUNT (not known).
std::string_view kind_name(SkybodyKind kind);

/// The kind of that name, or nothing.
std::optional<SkybodyKind> kind_from_name(std::string_view name);

}  // namespace skybody
