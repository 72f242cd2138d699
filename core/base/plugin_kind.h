// The kinds of plugins, by name. The list is in core/base/plugin_kinds.h.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/plugin_kinds.h"  // IWYU pragma: export

namespace skybody {

/// Fixed properties of a plugin kind.
struct PluginKindRow {
  const char* word;      ///< such as "controller"
  const char* folder;    ///< of the shipped plugins, such as "controllers"
  const char* function;  ///< name of the step function, such as "control"
};

/// In the order of SkybodyKind.
inline constexpr std::array<PluginKindRow, SKYBODY_KIND_COUNT> kPluginKinds = {{
#define SKYBODY_ROW(symbol, type, word, folder, function) {#word, #folder, #function},
    SKYBODY_PLUGIN_KINDS(SKYBODY_ROW)
#undef SKYBODY_ROW
}};

/// "controller", "sensor", ...; "plugin" for SKYBODY_KIND_COUNT (unknown).
constexpr const char* kind_name(SkybodyKind kind) {
  return kind < SKYBODY_KIND_COUNT ? kPluginKinds[kind].word : "plugin";
}

/// The kind with that name, or nullopt.
inline std::optional<SkybodyKind> kind_from_name(std::string_view name) {
  for (int kind = 0; kind < SKYBODY_KIND_COUNT; ++kind) {
    if (name == kPluginKinds[static_cast<std::size_t>(kind)].word) {
      return static_cast<SkybodyKind>(kind);
    }
  }
  return std::nullopt;
}

/// "controller, sensor, ... or effect".
inline std::string kind_names() {
  std::string names = kPluginKinds[0].word;
  for (std::size_t kind = 1; kind < kPluginKinds.size(); ++kind) {
    names += kind + 1 == kPluginKinds.size() ? " or " : ", ";
    names += kPluginKinds[kind].word;
  }
  return names;
}

}  // namespace skybody
