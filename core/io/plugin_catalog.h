// What the reader of scenarios asks about plugins: which there are and what they declare. The
// plugin host implements it; tests use a fake.
#pragma once

#include <string>
#include <vector>

#include "core/base/plugin_kind.h"
#include "core/model/parameter_spec.h"

namespace skybody {

/// What a plugin says about itself.
struct PluginDeclaration {
  SkybodyKind kind = SKYBODY_CONTROLLER;
  std::string name;
  std::string doc;      ///< one line
  std::string file;     ///< shared library
  std::string failure;  ///< why it was found but cannot be used; empty: it can
  std::vector<ParameterSpec> parameters;
};

/// All plugins that were found.
class PluginCatalog {
 public:
  virtual ~PluginCatalog() = default;

  /// The plugin `name` of `kind`, or null. Lives as long as the catalog.
  virtual const PluginDeclaration* find(SkybodyKind kind, const std::string& name) const = 0;
  /// Names of all plugins that are known to be of `kind`, sorted.
  virtual std::vector<std::string> names(SkybodyKind kind) const = 0;
  /// Names of plugins whose kind is not known before they are found, sorted.
  virtual std::vector<std::string> names_of_any_kind() const = 0;
};

}  // namespace skybody
