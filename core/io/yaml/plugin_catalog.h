// The scenario reader's interface to plugins: their names and declarations. The plugin host
// implements it; tests use a fake.
#pragma once

#include <string>
#include <vector>

#include "core/base/plugin_kind.h"
#include "core/model/parameter_spec.h"

namespace skybody {

/// The declaration of a plugin.
struct PluginDeclaration {
  SkybodyKind kind = SKYBODY_CONTROLLER;
  std::string name;
  std::string doc;      ///< one line
  std::string file;     ///< shared library
  std::string failure;  ///< the reason why a found plugin cannot be used; empty: it can
  std::vector<ParameterSpec> parameters;
};

/// All plugins found.
class PluginCatalog {
 public:
  virtual ~PluginCatalog() = default;

  /// The plugin `name` of `kind`, or null. Lives as long as the catalog.
  virtual const PluginDeclaration* find(SkybodyKind kind, const std::string& name) const = 0;
  /// Names of all plugins of the known kind `kind`, sorted.
  virtual std::vector<std::string> names(SkybodyKind kind) const = 0;
  /// Names of plugins whose kind is unknown until they are loaded, sorted.
  virtual std::vector<std::string> names_of_any_kind() const = 0;
};

}  // namespace skybody
