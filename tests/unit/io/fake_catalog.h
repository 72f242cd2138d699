// A plugin catalog without plugins, for tests of readers.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/io/yaml/plugin_catalog.h"

namespace skybody {

/// Declares a few plugins of each kind, including one that cannot be loaded.
class FakeCatalog : public PluginCatalog {
 public:
  FakeCatalog();
  const PluginDeclaration* find(SkybodyKind kind, const std::string& name) const override;
  std::vector<std::string> names(SkybodyKind kind) const override;
  std::vector<std::string> names_of_any_kind() const override;

 private:
  void add(SkybodyKind kind, const std::string& name, std::vector<ParameterSpec> parameters);

  std::map<SkybodyKind, std::map<std::string, PluginDeclaration>> plugins_;
};

}  // namespace skybody
